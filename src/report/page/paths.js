// Trajectory beside the truth, and the distance between them over time.

const nonEmpty = (path) => path && path.t_s && path.t_s.length > 0;

/** The lines of all views: the truth first, so that the estimate lies on it. */
function pathSeries() {
  const out = [];
  const recordings = new Set();
  const entry = (name, c, path, width) => ({ name, colour: c, width, t: path.t_s, x: path.x_m, y: path.y_m, z: path.z_m });
  runs.forEach((run, k) => {
    if (!nonEmpty(run.truth) || recordings.has(run.report.recording)) return;
    recordings.add(run.report.recording);
    out.push(entry(recordings.size > 1 ? `truth of ${'AB'[k]}` : 'truth', 'truth', run.truth, 3.2));
  });
  runs.forEach((run, k) => { if (nonEmpty(run.trajectory)) out.push(entry(runName(k), runColour(k), run.trajectory, 1.8)); });
  return out;
}

function pathViews() {
  const series = pathSeries();
  if (!series.length) {
    ['top-view', 'side-view', 'space-view'].forEach((id) => byId(id).replaceChildren(empty('the estimator never started')));
    return;
  }
  const [x, y, z] = ['x', 'y', 'z'].map((name) => ({ label: `${name}, m`, short: name }));
  lineChart(byId('top-view'), { plane: true, x, y, series });
  // Seen along the shorter side of the ground, so that the path is seen at its full length.
  const [xs, ys] = ['x', 'y'].map((axis) => extent(series.map((s) => s[axis])));
  const alongX = xs[1] - xs[0] >= ys[1] - ys[0];
  lineChart(byId('side-view'), {
    plane: true, x: alongX ? x : y, y: { ...z, label: 'z, m (up)' },
    series: series.map((s) => ({ ...s, x: alongX ? s.x : s.y, y: s.z })),
  });
  spaceView(byId('space-view'), { series });
  drawings.push(() => legend(byId('path-legend'), [
    ...series.map((s) => ({ name: s.name, colour: colour(s.colour) })),
    ...(series.some((s) => s.name === 'truth') ? [{ name: 'estimate laid on the truth: turned and shifted, not scaled' }] : []),
  ]));
}

/** The root mean square of all errors up to each: its last value is the ATE. */
function runningRms(errors) {
  let sum = 0;
  let count = 0;
  return errors.map((e) => {
    if (isNumber(e)) { sum += e * e; ++count; }
    return count ? Math.sqrt(sum / count) : null;
  });
}

function errorView() {
  const known = runs.map((run, k) => ({ run, k })).filter(({ run }) => nonEmpty(run.trajectory) && run.trajectory.error_m.some(isNumber));
  const figures = runs.map((run, k) => `${isComparison ? `${'AB'[k]}: ` : ''}ATE ${exact(accuracy(run, 'ate_rmse_m'))} m`).join(' · ');
  if (!known.length) {
    byId('error-words').textContent = runs.some((r) => isNumber(accuracy(r, 'ate_rmse_m'))) ? `${figures}, as the replay measured it` : '';
    byId('error-view').replaceChildren(empty(runs.some((r) => nonEmpty(r.trajectory)) ? 'there is no truth to compare with' : 'the estimator never started'));
    return;
  }
  byId('error-words').textContent = `${figures}: the root mean square of the distances below.`;
  const series = known.flatMap(({ run, k }) => [
    { name: isComparison ? `${'AB'[k]} distance` : 'distance to the truth', colour: runColour(k), x: run.trajectory.t_s, y: run.trajectory.error_m },
    { name: isComparison ? `${'AB'[k]} root mean square so far` : 'root mean square so far', colour: isComparison ? runColour(k) : 'truth', dash: '6 3', x: run.trajectory.t_s, y: runningRms(run.trajectory.error_m) },
  ]);
  lineChart(byId('error-view'), { x: { label: 'time after the first frame, s' }, y: { label: 'position error, m', from: 0 }, unit: 'm', series });
  drawings.push(() => legend(byId('error-legend'), series.map((s) => ({ name: s.name, colour: colour(s.colour), shape: s.dash ? 'dash' : '' }))));
}
