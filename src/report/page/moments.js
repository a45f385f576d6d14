// Frames with events, points and lines at a scrubber of moments; the histograms of all weights.

const layers = { frame: true, events: true, features: true, labels: false };
const layerNames = { frame: 'frame', events: 'events', features: 'points and lines', labels: 'moving (labels)' };
const momentsOf = (run) => (run.moments && run.moments.list) || [];

/** A picture of the page as pixels, once. */
const decoded = new Map();
function pictureOf(base64) {
  if (!decoded.has(base64)) {
    decoded.set(base64, new Promise((resolve) => {
      const image = new Image();
      image.onload = () => resolve(image);
      image.onerror = () => resolve(null);
      image.src = `data:image/png;base64,${base64}`;
    }));
  }
  return decoded.get(base64);
}

/** A grey picture as colours with alpha: `paint(grey)` gives [r, g, b, a] or nothing. */
function coloured(image, paint) {
  const canvas = el('canvas', { width: image.naturalWidth, height: image.naturalHeight });
  const c = canvas.getContext('2d');
  c.drawImage(image, 0, 0);
  const pixels = c.getImageData(0, 0, canvas.width, canvas.height);
  for (let i = 0; i < pixels.data.length; i += 4) {
    const value = paint(pixels.data[i]);
    pixels.data.set(value || [0, 0, 0, 0], i);
  }
  c.putImageData(pixels, 0, 0);
  return canvas;
}

const featureOf = (row) => {
  const [kind, u0, v0, u1, v1, w, used, moving, wTemporal, wGeometric] = row;
  const name = { i: 'image point', e: 'event point', l: 'line', L: 'line' }[kind];
  const ofEvents = kind === 'e' || kind === 'L';
  return { kind: name, ofEvents, u0, v0, u1, v1, w, used, moving, wTemporal, wGeometric, u: u0, v: v0, uEnd: u1, vEnd: v1 };
};

function sizeOf(run, moment) {
  if (run.moments.width_px) return [run.moments.width_px, run.moments.height_px];
  const us = moment.features.map((f) => f[1]);
  const vs = moment.features.map((f) => f[2]);
  return [Math.max(64, ...us) + 8, Math.max(48, ...vs) + 8];  // no recording: as large as what was seen
}

/** What belongs on the picture that is shown: what events of another camera show only on that camera's own. */
function featuresOn(run, moment) {
  const features = moment.features.map(featureOf);
  if (!run.moments.width_px || run.moments.same_sensor) return features;
  const onEvents = layers.events && moment.events && !(layers.frame && moment.frame);
  const share = run.moments.width_px / run.moments.event_width_px;
  const placed = (px) => (isNumber(px) ? (px + 0.5) * share - 0.5 : px);
  return features.filter((f) => f.ofEvents === Boolean(onEvents))
    .map((f) => (onEvents ? { ...f, u: placed(f.u0), v: placed(f.v0), uEnd: placed(f.u1), vEnd: placed(f.v1) } : f));
}

function drawFeatures(c, features, scale, dot) {
  for (const f of features) {
    const [x, y] = [(f.u + 0.5) * scale, (f.v + 0.5) * scale];
    const isLine = isNumber(f.u1);
    const width = dot * (f.used ? 0.6 : 0.45);
    c.beginPath();
    if (isLine) {
      c.moveTo(x, y);
      c.lineTo((f.uEnd + 0.5) * scale, (f.vEnd + 0.5) * scale);
    } else if (f.kind === 'event point') {
      c.rect(x - dot, y - dot, 2 * dot, 2 * dot);
    } else {
      c.arc(x, y, dot, 0, 2 * Math.PI);
    }
    // A dark rim, so that light colours stand out of a light picture; inside it a light one round what events show.
    for (const [rim, wide] of f.ofEvents ? [['#000', 3.4], ['#fff', 2]] : [['rgba(0, 0, 0, .65)', 1.6]]) {
      c.strokeStyle = rim;
      c.lineWidth = width + wide;
      c.stroke();
    }
    c.strokeStyle = c.fillStyle = weightColour(f.w);
    c.lineWidth = width;
    if (f.used && !isLine) c.fill(); else c.stroke();
  }
}

async function paintMoment(view) {
  const { run, canvas } = view;
  const moment = momentsOf(run)[view.index];
  const turn = ++view.turn;  // pictures decode later: an older request must not paint over a newer one
  const [width, height] = sizeOf(run, moment);
  const load = (name) => (layers[name] && moment[name] ? pictureOf(moment[name]) : null);
  const [frameImage, eventImage, labelImage] = await Promise.all(['frame', 'events', 'labels'].map(load));
  if (turn !== view.turn) return;
  const pixels = Math.max(canvas.parentNode.clientWidth, 240) * (window.devicePixelRatio || 1);
  const scale = pixels / width;
  canvas.width = Math.round(pixels);
  canvas.height = Math.round(height * scale);
  const c = canvas.getContext('2d');
  c.fillStyle = '#101214';
  c.fillRect(0, 0, canvas.width, canvas.height);
  c.imageSmoothingEnabled = false;
  const put = (image) => c.drawImage(image, 0, 0, canvas.width, canvas.height);
  if (frameImage) put(frameImage);
  const foreign = !run.moments.same_sensor && frameImage;  // another camera's events do not fit on this frame
  if (eventImage && !foreign) put(coloured(eventImage, (g) => (g < 64 ? null : [...(g > 191 ? palette.on : palette.off), frameImage ? 115 : 230])));
  if (labelImage) put(coloured(labelImage, (g) => (g === 255 ? [255, 255, 255, 90] : null)));
  if (layers.features) drawFeatures(c, featuresOn(run, moment), scale, Math.max(3, pixels / 190));
  describe(view, moment, foreign && eventImage);
}

function describe(view, moment, foreign) {
  const features = moment.features.map(featureOf);
  const count = (test) => features.filter(test).length;
  const weighed = features.filter((f) => isNumber(f.w));
  const mean = weighed.reduce((sum, f) => sum + f.w, 0) / weighed.length;
  const parts = [`t = ${moment.t_s.toFixed(2)} s`, `${features.length} features, ${count((f) => f.used)} used`];
  const lines = count((f) => f.kind === 'line');
  const eventPoints = count((f) => f.kind === 'event point');
  if (eventPoints) parts.push(`${eventPoints} event points, ${count((f) => f.kind === 'event point' && f.used)} used`);
  if (lines) parts.push(`${lines} lines`);
  if (count((f) => f.moving)) parts.push(`${count((f) => f.moving)} on what moves`);
  parts.push(weighed.length ? `mean weight ${short(mean)} of the ${weighed.length} that have one` : 'no evidence yet: features have no weight');
  if (isNumber(moment.event_count)) parts.push(`${short(moment.event_count)} events in ${view.run.moments.event_window_ms} ms`);
  if (foreign) parts.push('events, and what they show, are of another camera: switch the frame off to see them');
  if (isComparison) parts.unshift(runName(view.k));
  view.words.replaceChildren(...parts.map((part) => el('li', {}, part)));
}

function momentTip(view, event) {
  const moment = momentsOf(view.run)[view.index];
  const box = view.canvas.getBoundingClientRect();
  const [width] = sizeOf(view.run, moment);
  const u = ((event.clientX - box.left) / box.width) * width - 0.5;
  const v = ((event.clientY - box.top) / box.width) * width - 0.5;
  let best = { distance: (12 / box.width) * width };
  for (const f of featuresOn(view.run, moment)) {
    const distance = distanceTo(f, u, v);
    if (distance < best.distance) best = { distance, f };
  }
  if (!best.f) return '';
  const f = best.f;
  const cue = (name, w) => `${name}: ${isNumber(w) ? w.toFixed(3) : 'no evidence yet'}`;
  return [`${f.kind}${f.used ? ', used' : ', not used'}${f.moving ? ', on what moves' : ''}`, `(${f.u0} px, ${f.v0} px)`,
    cue('weight', f.w), cue('temporal cue', f.wTemporal), cue('geometric cue', f.wGeometric)].join('\n');
}

function distanceTo(f, u, v) {
  if (!isNumber(f.u1)) return Math.hypot(f.u - u, f.v - v);
  const [dx, dy] = [f.uEnd - f.u, f.vEnd - f.v];
  const share = Math.min(Math.max(((u - f.u) * dx + (v - f.v) * dy) / (dx * dx + dy * dy || 1), 0), 1);
  return Math.hypot(f.u + share * dx - u, f.v + share * dy - v);
}

function momentControls(lead) {
  const list = momentsOf(lead.run);
  const slider = el('input', { type: 'range', min: 0, max: list.length - 1, step: 1, value: lead.index, 'aria-label': 'moment' });
  const when = el('span', { class: 'when', 'aria-live': 'polite' });
  const go = (index) => {
    slider.value = index;
    when.textContent = `t = ${list[slider.value].t_s.toFixed(2)} s`;
    slider.setAttribute('aria-valuetext', when.textContent);
    setInstant(list[slider.value].t_s);
  };
  slider.addEventListener('input', () => go(Number(slider.value)));
  const step = (words, by) => {
    const button = el('button', { type: 'button', 'aria-label': words }, by < 0 ? '◀' : '▶');
    button.addEventListener('click', () => go(Math.min(Math.max(Number(slider.value) + by, 0), list.length - 1)));
    return button;
  };
  const there = (name) => name === 'features' || runs.some((r) => momentsOf(r).some((m) => m[name]));
  const boxes = Object.keys(layers).filter(there).map((name) => {
    const box = el('input', { type: 'checkbox' });
    box.checked = layers[name];
    box.addEventListener('change', () => { layers[name] = box.checked; redraw(); });
    return el('label', {}, box, layerNames[name]);
  });
  byId('moment-controls').replaceChildren(step('earlier', -1), slider, step('later', 1), when, ...boxes);
  go(lead.index);
}

function momentLegend() {
  const scale = el('i', { class: 'scale' });
  scale.style.background = `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map(weightColour).join(', ')})`;
  const host = byId('moment-legend');
  legend(host, [
    ...(runs.some((r) => momentsOf(r).some((m) => m.features.some((f) => f[0] === 'e'))) ? [
      { name: 'image point', colour: colour('muted'), shape: 'ring' }, { name: 'event point (white rim)', colour: colour('muted'), shape: 'square' }] : []),
    { name: 'used', colour: weightColour(1), shape: 'box' }, { name: 'not used', colour: weightColour(1), shape: 'ring' },
    { name: 'no evidence yet', colour: weightColour(null), shape: 'ring' },
    ...(runs.some((r) => momentsOf(r).some((m) => m.events)) ? [
      { name: 'event: brighter', colour: rgb(palette.on), shape: 'box' }, { name: 'event: darker', colour: rgb(palette.off), shape: 'box' }] : []),
  ]);
  host.prepend(el('span', {}, 'weight 0', scale, '1'));
}

function moments() {
  const views = runs.map((run, k) => ({ run, k, index: 0, turn: 0 })).filter(({ run }) => momentsOf(run).length);
  if (!views.length) {
    byId('moments').replaceChildren(empty('there are no features to show: features.csv is missing or has no rows'));
    return;
  }
  byId('moments').classList.add(isComparison ? 'two' : 'one');
  for (const view of views) {
    view.canvas = el('canvas', { role: 'img', 'aria-label': 'frame with events and features' });
    view.words = el('ul', { class: 'facts muted' });
    const host = el('div', {}, view.canvas);
    byId('moments').append(el('div', { class: 'moment' }, host, view.words));
    hover(view.canvas, (event) => momentTip(view, event));
    onInstant(() => {
      view.index = indexAt(momentsOf(view.run).map((m) => m.t_s), instant_s);
      paintMoment(view);
    });
    draw(host, () => paintMoment(view));
  }
  drawings.push(momentLegend);
  views[0].index = Math.floor(momentsOf(views[0].run).length / 2);
  momentControls(views[0]);
}

const cueNames = { w: 'weight', w_temporal: 'temporal cue', w_geometric: 'geometric cue' };

function histograms() {
  const host = byId('histograms');
  const all = runs.flatMap((run, k) => (run.histograms || []).map((h) => ({ ...h, run, k })));
  if (!all.length) { host.replaceChildren(empty('there is no features.csv')); return; }
  const labelled = runs.some((r) => r.features && r.features.labelled);
  byId('weight-words').textContent = labelled
    ? 'Features on something that moves, by the labels of the recording, against all others; each in per cent of its own number. 0: shut out.'
    : 'The recording has no labels of what moves: all features together, in per cent. 0: shut out.';
  for (const h of all) {
    const title = `${isComparison ? `${'AB'[h.k]}: ` : ''}${cueNames[h.name]}`;
    const box = el('div');
    host.append(el('figure', {}, el('figcaption', {}, title), box));
    if (!h.still) { box.append(empty('no evidence yet')); continue; }
    const series = [{ name: h.run.features.labelled ? 'still' : 'all', counts: h.still, colour: 'still' }];
    if (h.run.features.labelled) series.push({ name: 'moving', counts: h.moving, colour: 'moving' });
    histogramChart(box, { label: `${cueNames[h.name]} (0 … 1)`, series });
  }
  drawings.push(() => legend(byId('histogram-legend'), [
    { name: labelled ? 'features on what stands still' : 'all features', colour: colour('still'), shape: 'box' },
    ...(labelled ? [{ name: 'features on what moves', colour: colour('moving'), shape: 'box' }] : []),
  ]));
}
