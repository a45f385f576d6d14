// The trajectory in space on a canvas, seen in parallel projection and turned by hand.

/** spec: {series: [{name, colour, t, x, y, z, width}]} with z up, metres. */
function spaceView(host, spec) {
  const canvas = el('canvas', { class: 'space', tabindex: '0', role: 'img', 'aria-label': 'Trajectory in space; arrow keys turn it' });
  host.replaceChildren(canvas);
  const view = { yaw: -0.65, pitch: 0.5, zoom: 0.9 };
  const ranges = ['x', 'y', 'z'].map((axis) => extent(spec.series.map((s) => s[axis])));
  const middle = ranges.map(([low, high]) => (low + high) / 2);
  const radius = Math.max(1e-3, Math.hypot(...ranges.map(([low, high]) => (high - low) / 2)));
  let project = null;

  const paint = () => {
    const width = Math.max(host.clientWidth, 240);
    const height = Math.min(Math.max(width * 0.8, 230), 360);
    const ratio = window.devicePixelRatio || 1;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    canvas.style.height = `${height}px`;
    const c = canvas.getContext('2d');
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    project = projection(view, middle, (Math.min(width, height) / 2.25 / radius) * view.zoom, width, height);
    drawGround(c, project, ranges);
    for (const s of spec.series) drawPath(c, project, s);
    for (const s of spec.series) {
      if (!s.t.length) continue;
      const i = indexAt(s.t, instant_s);
      drawDot(c, project(s.x[i], s.y[i], s.z[i]), colour(s.colour));
    }
  };

  turnByHand(canvas, view, paint);
  hover(canvas, (event) => spaceTip(spec, canvas, project, event));
  onInstant(paint);
  draw(host, paint);
}

/** (x, y, z) to pixels: turned by yaw about z, then tilted by pitch. */
function projection(view, middle, scale, width, height) {
  const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
  return (x, y, z) => {
    const [dx, dy, dz] = [x - middle[0], y - middle[1], z - middle[2]];
    const across = cy * dx - sy * dy;
    const away = sy * dx + cy * dy;
    return [width / 2 + scale * across, height / 2 - scale * (cp * dz + sp * away)];
  };
}

function stroke(c, points, style, width) {
  c.beginPath();
  points.forEach(([px, py], i) => (i ? c.lineTo(px, py) : c.moveTo(px, py)));
  c.strokeStyle = style;
  c.lineWidth = width;
  c.lineJoin = 'round';
  c.stroke();
}

/** A grid of round steps at the lowest point, and the three axes with their names. */
function drawGround(c, project, ranges) {
  const pad = Math.max(...ranges.map(([low, high]) => high - low), 1e-3) * 0.05;
  const [xs, ys] = ranges.slice(0, 2).map(([low, high]) => [low - pad, high + pad]);
  const floor = ranges[2][0];
  const longest = Math.max(xs[1] - xs[0], ys[1] - ys[0]);
  const steps = ticks(0, longest, 6);
  const step = steps[1] - steps[0] || longest;
  const lines = ([low, high]) => Array.from(
    { length: Math.ceil(high / step) - Math.floor(low / step) + 1 }, (_, k) => (Math.floor(low / step) + k) * step);
  const [gx, gy] = [lines(xs), lines(ys)];
  const ends = (list) => [list[0], list[list.length - 1]];
  const [x0, x1] = ends(gx);
  const [y0, y1] = ends(gy);
  for (const x of gx) stroke(c, [project(x, y0, floor), project(x, y1, floor)], colour('line'), 1);
  for (const y of gy) stroke(c, [project(x0, y, floor), project(x1, y, floor)], colour('line'), 1);
  c.fillStyle = colour('muted');
  c.font = '11.5px system-ui, sans-serif';
  c.fillText(`grid ${short(step)} m`, 8, 16);
  const up = project(x0, y0, Math.max(ranges[2][1], floor + step));
  stroke(c, [project(x0, y0, floor), project(x1, y0, floor)], colour('muted'), 1);
  stroke(c, [project(x0, y0, floor), project(x0, y1, floor)], colour('muted'), 1);
  stroke(c, [project(x0, y0, floor), up], colour('muted'), 1);
  const name = (text, [px, py]) => c.fillText(text, Math.max(px + 4, 6), py + 3);
  name('x', project(x1, y0, floor));
  name('y', project(x0, y1, floor));
  name('z, up', up);
}

function drawPath(c, project, s) {
  if (!s.x.length) return;
  stroke(c, s.x.map((x, i) => project(x, s.y[i], s.z[i])), colour(s.colour), s.width || 1.8);
}

function drawDot(c, [px, py], style) {
  c.beginPath();
  c.arc(px, py, 4.5, 0, 2 * Math.PI);
  c.fillStyle = style;
  c.fill();
  c.strokeStyle = colour('card');
  c.lineWidth = 1.5;
  c.stroke();
}

/** Drag and arrow keys turn; wheel, two fingers, + and - zoom. */
function turnByHand(canvas, view, paint) {
  const fingers = new Map();
  const turn = (dx, dy) => {
    view.yaw += dx * 0.01;
    view.pitch = Math.min(Math.max(view.pitch + dy * 0.01, -Math.PI / 2), Math.PI / 2);
  };
  const zoom = (factor) => { view.zoom = Math.min(Math.max(view.zoom * factor, 0.3), 30); };
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y) || 1;
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener('pointermove', (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const before = fingers.size === 2 ? spread() : 0;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (fingers.size === 2) zoom(spread() / before);
    else turn(event.clientX - last.x, event.clientY - last.y);
    paint();
  });
  for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * 0.0015));
    paint();
  }, { passive: false });
  const keys = { ArrowLeft: [-10, 0], ArrowRight: [10, 0], ArrowUp: [0, -10], ArrowDown: [0, 10] };
  canvas.addEventListener('keydown', (event) => {
    if (keys[event.key]) turn(...keys[event.key]);
    else if (event.key === '+') zoom(1.15);
    else if (event.key === '-') zoom(1 / 1.15);
    else return;
    event.preventDefault();
    paint();
  });
}

function spaceTip(spec, canvas, project, event) {
  if (!project || event.buttons) return '';
  const box = canvas.getBoundingClientRect();
  let best = { distance: 16 };
  for (const s of spec.series) {
    for (let i = 0; i < s.x.length; ++i) {
      const [px, py] = project(s.x[i], s.y[i], s.z[i]);
      const distance = Math.hypot(px - (event.clientX - box.left), py - (event.clientY - box.top));
      if (distance < best.distance) best = { distance, s, i };
    }
  }
  if (!best.s) return '';
  const { s, i } = best;
  const place = ['x', 'y', 'z'].map((axis) => `${axis} ${s[axis][i].toFixed(3)} m`).join(', ');
  return `${s.name}, t = ${s.t[i].toFixed(2)} s\n${place}`;
}
