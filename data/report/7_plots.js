// What is plotted of a block: its error against a varied parameter (shadow-map size, kernel, samples), one line a technique,
// and against what it costs, with the front of those that no other beats in both. One diagram a view, all with the same axes.

function make_plot(some, box, start, measure) {
  const all = quantities.of(some, measure), varied = quantities.varied(some).filter(one => one.numeric);
  const errors = all.filter(one => !one.cost), costs = all.filter(one => one.cost && new Set(some.map(one.value).filter(value => value > 0)).size > 1);
  const across = [...varied.map(one => ({id: 'by ' + one.key, title: one.title, varied: one})), ...costs.map(one => ({id: one.id, title: one.axis, cost: one}))];
  const state = {error: quantities.default_error(all), across: across.find(one => one.id === start) ?? across.find(one => one.cost)};
  if (!errors.length || !state.across) return false;
  const figure = element('div', {className: 'diagrams'});

  // One series a technique; against a parameter, one for each setting of the other parameters.
  function series_of(ys) {
    const found = new Map();
    for (const entry of some) {
      const key = state.across.varied?.key, others = key ? quantities.others(entry, key) : '';
      const x = key ? entry.varied[key] : state.across.cost.value(entry), y = ys.value(entry);
      if (entry.status === 'failed' || typeof x !== 'number' || !Number.isFinite(y)) continue;
      const title = entry.title + (others ? ` (${others})` : '');
      if (!found.has(title)) found.set(title, {title, points: []});
      found.get(title).points.push({entry, x, y, x_text: key ? `${x} ${state.across.varied.unit}`.trim() : state.across.cost.text(x), y_text: ys.text(y)});
    }
    for (const one of found.values()) one.points.sort((a, b) => a.x - b.x);
    return [...found.values()];
  }

  function x_axis(points) {
    const values = points.map(p => p.x), least = Math.min(...values), most = Math.max(...values);
    if (!state.across.varied) return plotting.axis(values, {log: true, pad: [1.5, 2.2], text: value => value === 0 ? '0' : state.across.cost.text(value).replace(/\.0+(?=\D|$)/, '')});
    const log = least > 0 && most / least >= 4, distinct = state.across.varied.values;
    return plotting.axis(values, {log, pad: [1.15, 1.15], text: String, ticks: distinct.length <= 10 ? distinct : null});
  }
  function y_axis(points, ys) {
    const values = points.map(p => p.y), least = Math.min(...values), most = Math.max(...values);
    const log = ys.lower !== false && least > 0 && most / least > (state.across.varied?.key === 'samples' ? 2 : 20); // convergence is a straight line then
    return plotting.axis(values, {log, pad: [1.5, 1.6], from_zero: ys.lower !== false, text: value => String(+value.toPrecision(4))});
  }

  // How the error of independent samples falls, from the first point of the first series on.
  function guide_for(series, x, y) {
    if (state.across.varied?.key !== 'samples' || !x.log || !y.log || state.error !== 'rmse') return null;
    const from = series[0].points[0], to = Math.min(series[0].points.at(-1).x, from.x * (from.y / y.low) ** 2);
    return to > from.x ? {title: '∝ 1/√samples', points: [from, {x: to, y: from.y * Math.sqrt(from.x / to)}]} : null;
  }

  function draw() {
    const ys = errors.find(one => one.id === state.error) ?? errors[0], series = series_of(ys), points = series.flatMap(one => one.points);
    if (!points.length) { figure.replaceChildren(element('p', {className: 'note', textContent: 'Nothing to plot for this choice.'})); return; }
    const x = x_axis(points), y = y_axis(points, ys), lines = Boolean(state.across.varied), shown = [...new Set(points.map(p => p.entry.view))];
    const keys = view_keys([...new Set(some.map(entry => entry.view))]), alone = shown.length === 1, direct = alone && !lines && points.length <= 14;
    const direction = ys.lower === null ? '' : ys.lower ? ' (lower is better)' : ' (higher is better)';
    const diagrams = shown.map(view => {
      const own = series.map(one => ({...one, points: one.points.filter(p => p.entry.view === view)}));
      return plotting.diagram({title: alone ? '' : view_title(view, keys), series: own, x, y, x_title: state.across.title, y_title: ys.axis + direction, lines, lower: ys.lower !== false, direct,
        guide: guide_for(own.filter(one => one.points.length), x, y), width: alone ? 1160 : 640, height: alone ? 400 : 360});
    });
    figure.className = alone ? 'diagrams' : 'diagrams many';
    figure.replaceChildren(...(direct ? [] : [plotting.legend(series, lines)]), ...diagrams,
      ...(lines ? [] : [element('p', {className: 'note', textContent: 'The dashed line is the Pareto front: those that no other beats in both, among those that pay this cost at all.'})]));
  }

  box.append(element('div', {className: 'axes'},
    selection('Error', errors.map(one => ({id: one.id, title: one.title})), state.error, id => { state.error = id; draw(); }),
    selection('Against', across, state.across.id, id => { state.across = across.find(one => one.id === id); draw(); })), figure);
  draw();
  return true;
}
