// Charts in SVG: lines over an axis or in a plane, and bars. Each draws itself anew when its width changes.

/** Round steps that cover low ... high with about `count` of them. */
function ticks(low, high, count) {
  const span = Math.max(high - low, 1e-12);
  const raw = span / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= raw * 0.999);
  const out = [];
  // By whole numbers of steps: sums of a step would end near zero instead of at it.
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; ++k) out.push(Number((k * step).toPrecision(12)));
  return out;
}

/** The number with as many decimals as tell it from its neighbours. */
function tickText(v, all) {
  const step = all.length > 1 ? Math.abs(all[1] - all[0]) : Math.abs(v) || 1;
  if (Math.abs(v) >= 10000) return short(v);
  return v.toFixed(Math.min(Math.max(-Math.floor(Math.log10(step) + 1e-9), 0), 8));
}

function extent(lists) {
  let low = Infinity;
  let high = -Infinity;
  for (const list of lists)
    for (const v of list)
      if (isNumber(v)) { low = Math.min(low, v); high = Math.max(high, v); }
  return low <= high ? [low, high] : [0, 1];
}

/** The frame of a chart: scales, grid, labels. `x` and `y`: {label, low, high}. */
function frame(width, height, x, y) {
  const box = { left: 66, right: 12, top: 10, bottom: 40 };
  const plot = { x0: box.left, x1: width - box.right, y0: height - box.bottom, y1: box.top };
  const X = (v) => plot.x0 + ((v - x.low) / (x.high - x.low)) * (plot.x1 - plot.x0);
  const Y = (v) => plot.y0 - ((v - y.low) / (y.high - y.low)) * (plot.y0 - plot.y1);
  const root = svg('svg', { viewBox: `0 0 ${width} ${height}`, height, role: 'img' });
  const xTicks = ticks(x.low, x.high, (plot.x1 - plot.x0) / 58);
  const yTicks = ticks(y.low, y.high, (plot.y0 - plot.y1) / 32);
  for (const v of xTicks) {
    root.append(svg('line', { class: 'gridline', x1: X(v), x2: X(v), y1: plot.y0, y2: plot.y1 }));
    root.append(svg('text', { x: X(v), y: plot.y0 + 15, 'text-anchor': 'middle' }, tickText(v, xTicks)));
  }
  for (const v of yTicks) {
    root.append(svg('line', { class: 'gridline', x1: plot.x0, x2: plot.x1, y1: Y(v), y2: Y(v) }));
    root.append(svg('text', { x: plot.x0 - 6, y: Y(v) + 4, 'text-anchor': 'end' }, tickText(v, yTicks)));
  }
  root.append(svg('path', { class: 'axis', fill: 'none', d: `M${plot.x0},${plot.y1}V${plot.y0}H${plot.x1}` }));
  root.append(svg('text', { x: (plot.x0 + plot.x1) / 2, y: height - 5, 'text-anchor': 'middle' }, x.label));
  root.append(svg('text', {
    transform: `translate(12 ${(plot.y0 + plot.y1) / 2}) rotate(-90)`, 'text-anchor': 'middle',
  }, y.label));
  return { root, X, Y, plot };
}

/** A path through the points; a missing value is a hole. */
function pathThrough(xs, ys, X, Y) {
  let d = '';
  let pen = false;
  for (let i = 0; i < xs.length; ++i) {
    if (!isNumber(xs[i]) || !isNumber(ys[i])) { pen = false; continue; }
    d += `${pen ? 'L' : 'M'}${X(xs[i]).toFixed(1)},${Y(ys[i]).toFixed(1)}`;
    pen = true;
  }
  return d;
}

/** Widens both ranges so that a metre is as long on either axis. */
function equalise(x, y, width, height) {
  const perPixel = Math.max((x.high - x.low) / (width - 78), (y.high - y.low) / (height - 50));
  for (const [range, pixels] of [[x, width - 78], [y, height - 50]]) {
    const middle = (range.low + range.high) / 2;
    range.low = middle - (perPixel * pixels) / 2;
    range.high = middle + (perPixel * pixels) / 2;
  }
}

function padded([low, high], share, from) {
  const pad = (high - low || Math.abs(high) || 1) * share;
  return { low: isNumber(from) ? from : low - pad, high: high + pad };
}

const indexAt = (times, t) => {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < t) low = middle + 1; else high = middle;
  }
  return low > 0 && Math.abs(times[low - 1] - t) < Math.abs(times[low] - t) ? low - 1 : low;
};

/**
 * Lines. spec: {x: {label}, y: {label, from}, height, series: [{name, x, y, t, colour, dash, width, dots}],
 * level: {value, name}, plane, unit}. In a plane both axes have one scale and the nearest point is named;
 * otherwise the values at the pointer's x are.
 */
function lineChart(host, spec) {
  const paint = () => {
    const width = Math.max(host.clientWidth, 240);
    const height = spec.plane ? Math.min(Math.max(width * 0.8, 230), 360) : spec.height || 240;
    const x = { label: spec.x.label, ...padded(extent(spec.series.map((s) => s.x)), spec.plane ? 0.06 : 0) };
    const y = { label: spec.y.label, ...padded(extent(spec.series.map((s) => s.y)), 0.08, spec.y.from) };
    if (spec.plane) equalise(x, y, width, height);
    const { root, X, Y, plot } = frame(width, height, x, y);
    root.setAttribute('aria-label', `${spec.y.label} over ${spec.x.label}`);
    if (spec.level && isNumber(spec.level.value)) {
      const at = Y(spec.level.value);
      root.append(svg('line', { x1: plot.x0, x2: plot.x1, y1: at, y2: at, stroke: colour('muted'), 'stroke-dasharray': '5 4' }));
    }
    for (const s of spec.series) {
      root.append(svg('path', {
        d: pathThrough(s.x, s.y, X, Y), fill: 'none', stroke: colour(s.colour), 'stroke-width': s.width || 1.8,
        'stroke-linejoin': 'round', ...(s.dash ? { 'stroke-dasharray': s.dash } : {}),
      }));
    }
    const mark = svg('g', {});
    const markInstant = () => {
      mark.replaceChildren();
      if (!spec.plane) {
        if (instant_s < x.low || instant_s > x.high) return;
        mark.append(svg('line', { x1: X(instant_s), x2: X(instant_s), y1: plot.y0, y2: plot.y1, stroke: colour('mark'), 'stroke-opacity': 0.55 }));
        return;
      }
      for (const s of spec.series.filter((one) => one.t && one.t.length)) {
        const i = indexAt(s.t, instant_s);
        mark.append(svg('circle', { cx: X(s.x[i]), cy: Y(s.y[i]), r: 4.5, fill: colour(s.colour), stroke: colour('card'), 'stroke-width': 1.5 }));
      }
    };
    markInstant();
    root.append(mark);
    spec.markInstant = markInstant;
    hover(root, (event) => lineTip(spec, event, root, { X, Y, plot, x, width }));
    host.replaceChildren(root);
  };
  onInstant(() => spec.markInstant && spec.markInstant());
  draw(host, paint);
}

function lineTip(spec, event, root, { X, Y, plot, x, width }) {
  const box = root.getBoundingClientRect();
  const px = ((event.clientX - box.left) / box.width) * width;
  const py = ((event.clientY - box.top) / box.width) * width;
  if (px < plot.x0 || px > plot.x1) return '';
  if (!spec.plane) {
    const at = x.low + ((px - plot.x0) / (plot.x1 - plot.x0)) * (x.high - x.low);
    const lines = spec.series.filter((s) => s.x.length).map((s) => `${s.name}: ${withUnit(s.y[indexAt(s.x, at)], spec.unit)}`);
    return [`t = ${at.toFixed(2)} s`, ...lines].join('\n');
  }
  let best = { distance: 24 };
  for (const s of spec.series) {
    for (let i = 0; i < s.x.length; ++i) {
      const distance = Math.hypot(X(s.x[i]) - px, Y(s.y[i]) - py);
      if (distance < best.distance) best = { distance, s, i };
    }
  }
  if (!best.s) return '';
  const { s, i } = best;
  return `${s.name}, t = ${s.t[i].toFixed(2)} s\n${spec.x.short} ${s.x[i].toFixed(3)} m, ${spec.y.short} ${s.y[i].toFixed(3)} m`;
}

/** Groups of bars over 0 ... 1. spec: {label, series: [{name, counts, colour}]}; each in per cent of its sum. */
function histogramChart(host, spec) {
  const shares = spec.series.map(({ counts }) => {
    const sum = counts.reduce((a, b) => a + b, 0);
    return counts.map((count) => (sum > 0 ? (100 * count) / sum : 0));
  });
  draw(host, () => {
    const width = Math.max(host.clientWidth, 240);
    const x = { label: spec.label, low: 0, high: 1 };
    const y = { label: 'share of features, %', low: 0, high: Math.max(1, extent(shares)[1]) * 1.08 };
    const { root, X, Y, plot } = frame(width, 210, x, y);
    const bins = spec.series[0].counts.length;
    const bar = (plot.x1 - plot.x0) / bins / spec.series.length;
    spec.series.forEach((s, k) => shares[k].forEach((share, i) => root.append(svg('rect', {
      x: X(i / bins) + k * bar + 0.5, width: Math.max(bar - 1, 0.5), y: Y(share), height: plot.y0 - Y(share), fill: colour(s.colour),
    }))));
    hover(root, (event) => {
      const box = root.getBoundingClientRect();
      const px = ((event.clientX - box.left) / box.width) * width;
      const i = Math.floor(((px - plot.x0) / (plot.x1 - plot.x0)) * bins);
      if (i < 0 || i >= bins) return '';
      const range = `${(i / bins).toFixed(2)} … ${((i + 1) / bins).toFixed(2)}`;
      return [range, ...spec.series.map((s, k) => `${s.name}: ${short(shares[k][i])} % (${short(s.counts[i])} features)`)].join('\n');
    });
    host.replaceChildren(root);
  });
}
