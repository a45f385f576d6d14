// The head of the page: which run, its key figures, and what is missing.

const accuracy = (run, name) => (run.accuracy || {})[name];

/** Name, value of a run, unit, and words for the pointer. */
const keyFigures = [
  ['ATE', (r) => accuracy(r, 'ate_rmse_m'), 'm', 'Root mean square distance to the truth after a rigid alignment'],
  ['MPE', (r) => accuracy(r, 'mpe_percent'), '%', 'Mean distance to the truth, in per cent of the path'],
  ['RPE in 1 s', (r) => accuracy(r, 'rpe_trans_m'), 'm', 'Relative error over 1 s, translation'],
  ['RPE in 1 s', (r) => accuracy(r, 'rpe_rot_deg'), '°', 'Relative error over 1 s, rotation'],
  ['coverage', (r) => (isNumber(accuracy(r, 'coverage')) ? 100 * accuracy(r, 'coverage') : null), '%', "Share of the frames' time that has poses"],
  ['CPU per frame', (r) => r.report.cpu_ms_per_frame, 'ms', 'Processor time for a frame, reading the recording included'],
  ['started after', (r) => r.report.initialised_at_s, 's', 'Time from the first frame to the first pose'],
  ['length', (r) => r.report.duration_s, 's', 'Time from the first frame to the last'],
  ['resets', (r) => r.report.resets, '', 'How often the estimate was lost or bridged a gap of the IMU'],
];

function figureBox([name, value, unit, words]) {
  const v = value(runs[0]);
  const small = unit === 'm' && isNumber(v) && v < 0.01;  // three digits have to fit in a box
  const number = el('div', { class: 'value' }, short(small ? 1000 * v : v));
  if (isNumber(v) && unit) number.append(' ', el('small', {}, small ? 'mm' : unit));
  const detail = name === 'ATE' && isNumber(v) ? `${words}: ${exact(v)} m` : words;
  const box = el('div', { class: 'figure' }, el('div', { class: 'name' }, name), number);
  hover(box, () => detail);
  return box;
}

function comparisonTable() {
  const rows = keyFigures.map(([name, value, unit]) => {
    const [a, b] = runs.map(value);
    const both = isNumber(a) && isNumber(b);
    const sign = both && b > a ? '+' : '';
    const difference = el('span', {}, both ? `${sign}${short(b - a)} ${unit === '%' ? 'points' : unit}` : '–');
    if (both && a !== 0) difference.append(el('span', { class: 'share' }, `${sign}${short((100 * (b - a)) / Math.abs(a))} %`));
    return [name, withUnit(a, unit), withUnit(b, unit), difference];
  });
  const head = (k) => el('span', { class: runColour(k) }, runName(k));
  return el('div', { class: 'card' }, table(['', head(0), head(1), 'B − A'], rows));
}

function summary() {
  document.title = `${runs.map((r) => r.name).join(' and ')} – pled-vins`;
  byId('title').textContent = isComparison ? `${runs[0].name} and ${runs[1].name}` : runs[0].name;
  byId('subtitle').textContent = [...new Set(runs.map((r) => `recording ${r.report.recording || 'unknown'}`))].join(' · ');
  const notes = runs.flatMap((run, k) => run.notes.map((note) => (isComparison ? `${'AB'[k]}: ${note}` : note)));
  byId('notes').hidden = notes.length === 0;
  byId('notes').replaceChildren(...notes.map((note) => el('li', {}, note)));
  if (isComparison) {
    byId('figures').replaceChildren(comparisonTable());
  } else {
    byId('figures').className = 'figures';
    byId('figures').replaceChildren(...keyFigures.map(figureBox));
  }
}

const headOf = (first) => [first, ...runs.map((_, k) => (isComparison ? el('span', { class: runColour(k) }, 'AB'[k]) : 'value'))];

function stageTable() {
  const names = [...new Set(runs.flatMap((r) => Object.keys(r.report.stages || {})))];
  if (!names.length) return empty('no times were measured');
  const time = (us) => (isNumber(us) && us < 100 ? withUnit(us, 'µs') : withUnit(isNumber(us) ? us / 1000 : null, 'ms'));
  const longest = Math.max(...runs.flatMap((r) => Object.values(r.report.stages || {}).map((s) => s.p99_us || 0)), 1);
  const rows = names.flatMap((name) => runs.map((run, k) => {
    const s = (run.report.stages || {})[name] || {};
    const meter = el('span', { class: 'meter' });
    meter.style.width = `${(100 * (s.p99_us || 0)) / longest}%`;
    const label = el('span', isComparison ? { class: runColour(k) } : {}, isComparison ? `${name}, ${'AB'[k]}` : name);
    return [el('span', {}, label, meter), ...[s.p50_us, s.p99_us, s.max_us].map(time)];
  }));
  return table(['stage (bar: 99 %)', 'median', '99 %', 'longest'], rows);
}

function memoryTable() {
  const m = (run) => run.report.memory || {};
  return table(headOf(''), [
    ['static buffers of the estimator', ...runs.map((r) => bytesText(m(r).static_bytes))],
    ['peak of the process, readers and solver included', ...runs.map((r) => bytesText(m(r).peak_rss_bytes))],
    ['allocations after the start', ...runs.map((r) => short(m(r).allocations_after_start))],
  ]);
}

/** The settings as they are, or the lines in which two runs differ. */
function configBlock() {
  const known = runs.filter((r) => r.config);
  if (!known.length) return empty('config.yaml is not there');
  const out = el('div');
  if (isComparison && known.length === 2) {
    const values = runs.map((r) => settingsOf(r.config));
    const keys = [...new Set(values.flatMap((v) => [...v.keys()]))];
    const rows = keys.filter((key) => values[0].get(key) !== values[1].get(key)).map((key) => [key, ...values.map((v) => v.get(key) ?? '–')]);
    out.append(rows.length ? table(headOf('settings that differ'), rows) : empty('the settings of both runs are the same'));
  }
  runs.forEach((run, k) => {
    if (run.config) out.append(el('details', {}, el('summary', {}, isComparison ? `all settings of ${'AB'[k]}` : 'all settings (config.yaml)'), el('pre', { tabindex: '0' }, run.config)));
  });
  return out;
}

/** `section.key` to value, of the documented YAML. */
function settingsOf(text) {
  const values = new Map();
  let section = '';
  for (const line of text.split('\n')) {
    const found = /^( *)([A-Za-z0-9_]+): *(.*)$/.exec(line);
    if (!found) continue;
    if (!found[1]) section = found[3] ? '' : `${found[2]}.`;
    if (found[3]) values.set(found[1] ? section + found[2] : found[2], found[3]);
  }
  return values;
}

function tables() {
  byId('stages').replaceChildren(stageTable());
  byId('memory').replaceChildren(memoryTable());
  byId('version').replaceChildren(table(headOf(''), [
    ['version', ...runs.map((r) => r.report.version || 'unknown')],
    ['results', ...runs.map((r) => r.folder)],
    ['clock at the first frame', ...runs.map((r) => (isNumber(r.first_stamp_s) ? `${r.first_stamp_s.toFixed(6)} s` : '–'))],
  ]));
  byId('config').replaceChildren(configBlock());
}
