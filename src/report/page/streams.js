// What came from the sensors: rates in bins of a second, gaps, faults, and how many features there were.

const streamRows = [
  ['frames', 'frames', 'frames/s'],
  ['imu', 'IMU', 'samples/s'],
  ['events', 'events', 'events/s'],
  ['poses', 'poses', 'poses/s'],
];

/** One row of bars a stream over one axis of time, gaps marked; resets below. */
function timelineOf(host, run, k) {
  const rows = streamRows.filter(([key]) => run.rates && run.rates[key] && run.rates[key].per_s);
  const resets = (run.report.reset_stamps_s || []).map((stamp_s) => stamp_s - run.first_stamp_s);
  const length_s = Math.max(run.length_s || 0, 1e-3);
  draw(host, () => {
    const width = Math.max(host.clientWidth, 240);
    const [left, right, rowHeight] = [12, 12, 66];
    const height = rows.length * rowHeight + 74;
    const X = (t) => left + (Math.min(Math.max(t, 0), length_s) / length_s) * (width - left - right);
    const root = svg('svg', { viewBox: `0 0 ${width} ${height}`, height, role: 'img', 'aria-label': 'sensor rates over time' });
    rows.forEach(([key, name, unit], i) => streamRow(root, { ...run.rates[key], name, unit }, i * rowHeight, X, length_s));
    const base = rows.length * rowHeight;
    const words = resets.length ? `resets: ${resets.length}` : `resets: ${run.report.resets ? `${run.report.resets}, at unknown times` : 'none'}`;
    root.append(svg('text', { x: left, y: base + 14 }, words));
    for (const t of resets) root.append(svg('path', { d: `M${X(t)},${base + 20}l5,9h-10z`, fill: colour('bad') }));
    root.append(svg('line', { class: 'axis', x1: X(0), x2: X(length_s), y1: base + 34, y2: base + 34 }));
    for (const t of ticks(0, length_s, width / 65)) {
      root.append(svg('text', { x: X(t), y: base + 49, 'text-anchor': 'middle' }, short(t)));
    }
    root.append(svg('text', { x: width / 2, y: base + 67, 'text-anchor': 'middle' }, 'time after the first frame, s'));
    hover(root, (event) => timelineTip(event, root, run, rows, { left, right, width, rowHeight, length_s }));
    host.replaceChildren(root);
  });
}

function streamRow(root, stream, top, X, length_s) {
  const whole = stream.per_s.filter((_, i) => i + 1 <= length_s);
  const highest = Math.max(...stream.per_s, 1);
  const mean = whole.length ? whole.reduce((a, b) => a + b, 0) / whole.length : null;
  const [base, tall] = [top + 58, 36];
  let words = `${stream.name}: ${withUnit(mean, stream.unit)} (most ${short(highest)})`;
  if (stream.gap_count) words += `; ${stream.gap_count} ${stream.gap_count > 1 ? 'gaps' : 'gap'} > ${withUnit(stream.gap_limit_s * 1000, 'ms')}`;
  root.append(svg('text', { x: X(0), y: top + 14 }, words));
  stream.per_s.forEach((count, i) => {
    const begin = X(i);
    const end = X(Math.min(i + 1, length_s));
    // The last bin is shorter than a second: its rate is what counts, not its number.
    const share = Math.min(count / Math.max(Math.min(1, length_s - i), 0.05), highest) / highest;
    if (end - begin < 0.3) return;
    root.append(svg('rect', { x: begin, width: Math.max(end - begin - (end - begin > 4 ? 1 : 0), 0.3), y: base - tall * share, height: tall * share, fill: colour('bar') }));
  });
  root.append(svg('line', { class: 'axis', x1: X(0), x2: X(length_s), y1: base, y2: base }));
  for (const [begin_s, gap_s] of stream.gaps) {
    const at = X(begin_s);
    root.append(svg('rect', { x: at, width: Math.max(X(begin_s + gap_s) - at, 2), y: base - tall - 2, height: tall + 4, fill: colour('bad-fill'), stroke: colour('bad'), 'stroke-width': 0.7 }));
  }
}

function timelineTip(event, root, run, rows, { left, right, width, rowHeight, length_s }) {
  const box = root.getBoundingClientRect();
  const px = ((event.clientX - box.left) / box.width) * width;
  const t = ((px - left) / (width - left - right)) * length_s;
  const row = Math.floor((((event.clientY - box.top) / box.width) * width) / rowHeight);
  if (t < 0 || t > length_s || row >= rows.length) return '';
  const [key, name] = rows[row];
  const stream = run.rates[key];
  const second = Math.min(Math.floor(t), stream.per_s.length - 1);
  const gap = stream.gaps.find(([begin_s, gap_s]) => t >= begin_s - 0.05 && t <= begin_s + gap_s + 0.05);
  const words = [`${name}, second ${second} … ${second + 1} s`, `${short(stream.per_s[second])} in it`];
  if (gap) words.push(`none from ${gap[0].toFixed(3)} s on for ${gap[1].toFixed(3)} s`);
  return words.join('\n');
}

function flowTable() {
  const cell = (run, key, part) => short(((run.report[key] || {})[part]));
  const rows = ['frames', 'imu', 'events'].flatMap((key) => runs.map((run, k) => [
    el('span', isComparison ? { class: runColour(k) } : {}, `${key === 'imu' ? 'IMU samples' : key}${isComparison ? `, ${'AB'[k]}` : ''}`),
    ...(run.report[key] ? ['in', 'used', 'dropped'].map((part) => cell(run, key, part)) : ['none', '–', '–'])]));
  return table(['stream, items', 'came in', 'used', 'dropped'], rows);
}

function faultTable() {
  const kinds = [...new Set(runs.flatMap((r) => Object.keys(r.report.faults || {})))];
  if (!kinds.length) return empty('no faults were counted');
  return table(headOf('fault').map((head, i) => (i && !isComparison ? 'times' : head)),
    kinds.map((kind) => [kind.replaceAll('_', ' '), ...runs.map((r) => short((r.report.faults || {})[kind] || 0))]));
}

function streams() {
  runs.forEach((run, k) => {
    const host = el('div');
    if (isComparison) byId('timeline').append(el('h3', { class: runColour(k) }, runName(k)));
    byId('timeline').append(host);
    timelineOf(host, run, k);
  });
  byId('flows').replaceChildren(flowTable());
  byId('faults').replaceChildren(faultTable());
}

const dashShapes = { '2 3': 'dots', '8 3': 'dash' };

/** Lines of run.features over time: `kinds` of [key, name, dash, colour, width]. Nothing where all is nothing. */
function featureLines(kinds, is) {
  return runs.flatMap((run, k) => (run.features && run.features.t_s.length ? kinds
    .filter(([key]) => run.features[key].some(is))
    .map(([key, name, dash, own, width]) => ({
      name: isComparison ? `${'AB'[k]} ${name}` : name, dash, x: run.features.t_s, y: run.features[key], width,
      colour: isComparison ? runColour(k) : own,
    })) : []));
}

function featureChart(view, key, series, y, nothing) {
  if (!series.length) { byId(view).replaceChildren(empty(nothing)); return; }
  lineChart(byId(view), { x: { label: 'time after the first frame, s' }, y, unit: '', height: 200, series });
  drawings.push(() => legend(byId(key), series.map((s) => ({ name: s.name, colour: colour(s.colour), shape: dashShapes[s.dash] || '' }))));
}

function featureView() {
  const series = featureLines([
    ['image_points', 'image points', '', 'truth', 1.2], ['event_points', 'event points', '2 3', 'b', 1.4], ['lines', 'lines', '8 3', 'truth', 1.2],
    ['used', 'used, all kinds', '', 'a', 2], ['event_points_used', 'event points used', '', 'b', 2]], (n) => n > 0);
  featureChart('feature-view', 'feature-legend', series, { label: 'features of a frame', from: 0 }, 'there is no features.csv');
}

function temporalView() {
  const kinds = [['temporal_image', 'image points', '', 'a', 2], ['temporal_event', 'event points', '', 'b', 1.6]];
  if (!isComparison && runs[0].features && runs[0].features.labelled) {
    kinds[0][1] += ', still';
    kinds[1][1] += ', still';
    kinds.push(['temporal_image_moving', 'image points, moving', '2 3', 'a', 1.8], ['temporal_event_moving', 'event points, moving', '2 3', 'b', 1.8]);
  }
  if (isComparison) kinds[1][2] = '2 3';
  featureChart('temporal-view', 'temporal-legend', featureLines(kinds, isNumber), { label: 'median weight', from: 0 }, 'no evidence yet');
}
