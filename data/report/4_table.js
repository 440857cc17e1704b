// The table of techniques and metrics, sorted by any column, the best and the worst of each marked.

const table = (() => {
  const measures = [{id: 'visibility', title: 'Visibility'}, {id: 'shaded', title: 'Shaded'}]
    .filter(measure => entries.some(entry => Object.keys(entry.metrics[measure.id]).length > 0));
  const state = {measure: measures[0]?.id ?? 'visibility', column: null, descending: false};
  const press = segments(document.getElementById('measure'), measures, measure => { state.measure = measure; fill(); });

  // {id, title, hint, value(entry), text(value), lower: whether less is better}
  function columns() {
    const metric_columns = report.metrics
      .filter(metric => entries.some(entry => metric.id in entry.metrics[state.measure]))
      .map(metric => ({
        id: metric.id, title: short_title(metric.id), hint: `${metric.title}: ${metric.formula}`, lower: metric.lower_is_better,
        value: entry => metric_value(entry, state.measure, metric.id), text: metric_text(metric.id, entries.map(entry => metric_value(entry, state.measure, metric.id))),
      }));
    const cost = (id, title, hint, value, text) => ({id, title, hint, value, text: v => v === undefined ? '–' : text(v), lower: true});
    return metric_columns.concat([
      cost('fragments', 'Fragments', 'fragments covered in all passes: the fill', entry => total(entry, 'fragments_covered'), compact),
      cost('texels', 'Texels', 'texels fetched in all passes', entry => total(entry, 'texels_fetched'), compact),
      cost('memory', 'Memory', 'render targets and scratch memory at their peak', entry => entry.peak_bytes || undefined, bytes),
      cost('seconds', 'Time', 'seconds on the machine that made the images', entry => entry.seconds || undefined, seconds),
    ].filter(column => entries.some(entry => column.value(entry) !== undefined)));
  }

  const short_titles = {mae: 'MAE', mse: 'MSE', rmse: 'RMSE', psnr: 'PSNR', ssim: 'SSIM', ms_ssim: 'MS-SSIM', flip: 'ꟻLIP', max: 'Max', leak: 'Leak', false_shadow: 'False shadow', over: 'Over', under: 'Under'};
  function short_title(id) { return short_titles[id] ?? id.replaceAll('_', ' ').replace(/^./, c => c.toUpperCase()); }

  // Competitors are all but the reference, whose errors are zero by definition.
  const rivals = entries.filter(entry => entry !== reference);

  function extremes(column) {
    const values = rivals.map(column.value).filter(value => value !== undefined);
    const low = Math.min(...values), high = Math.max(...values);
    // A mark that half of them share marks nothing.
    const unless_common = value => values.filter(one => one === value).length * 2 >= values.length ? null : value;
    return {best: unless_common(column.lower ? low : high), worst: unless_common(column.lower ? high : low), high: Math.max(...values.filter(Number.isFinite), 0)};
  }

  function cell(entry, column, marks) {
    const value = column.value(entry), rival = entry !== reference;
    const made = element('td', {className: 'amount'}, element('span', {textContent: column.text(value)}));
    if (rival && value !== undefined && value === marks.best) made.classList.add('best');
    if (rival && value !== undefined && value === marks.worst) made.classList.add('worst');
    if (rival && Number.isFinite(value) && marks.high > 0) {
      const bar = element('i');
      bar.style.width = `calc((100% - 18px) * ${Math.max(0, value / marks.high)})`;
      made.append(bar);
    }
    return made;
  }

  function ordered(all) {
    const column = all.find(one => one.id === state.column), sign = state.descending ? -1 : 1;
    const rows = [...rivals];
    if (state.column === 'name') rows.sort((a, b) => sign * a.title.localeCompare(b.title));
    // What has no value comes last in both directions.
    else if (column) rows.sort((a, b) => {
      const x = column.value(a), y = column.value(b);
      return x === undefined || y === undefined ? (x === undefined) - (y === undefined) : x === y ? 0 : x < y ? -sign : sign;
    });
    return reference ? rows.concat(reference) : rows;
  }

  function heading(id, title, hint, lower) {
    const button = element('button', {type: 'button', textContent: title, title: hint});
    button.addEventListener('click', () => {
      state.descending = state.column === id ? !state.descending : !lower;
      state.column = id;
      fill();
    });
    const made = element('th', {scope: 'col'}, button);
    if (state.column === id) made.setAttribute('aria-sort', state.descending ? 'descending' : 'ascending');
    return made;
  }

  function fill() {
    press(state.measure);
    const all = columns(), marks = all.map(extremes);
    const head = element('thead', {}, element('tr', {}, heading('name', 'Technique', '', true),
      ...all.map(column => heading(column.id, column.title, column.hint, column.lower))));
    const body = element('tbody', {}, ...ordered(all).map(entry => {
      const name = element('button', {type: 'button', className: 'name', title: 'Show its image'},
        element('span', {className: 'number', textContent: entries.indexOf(entry) + 1}), entry.title);
      name.addEventListener('click', () => viewer.open(entry, entry.visibility ? 'visibility' : 'shaded'));
      const label = entry === reference ? 'reference' : entry.kind;
      return element('tr', {className: entry === reference ? 'reference' : ''},
        element('th', {scope: 'row'}, name, ' ', label ? element('span', {className: 'kind', textContent: label}) : ''),
        ...all.map((column, i) => cell(entry, column, marks[i])));
    }));
    document.getElementById('table').replaceChildren(head, body);
    const on = state.measure === 'visibility' ? 'visibility' : 'the shaded image';
    document.getElementById('table-note').textContent = (reference ? `Errors of ${on} against ${reference.title}. ` : '') +
      'The best of each column is green with a full dot, the worst red with an open one; the bars are relative to the column’s largest value. A click on a title sorts.';
  }
  return {fill, columns, short_title, rivals};
})();
