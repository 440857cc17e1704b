// The table of a block of entries, arranged as a paper's: rows are techniques in groups of one view, columns are metrics and
// costs, or the values of a varied parameter, or scenes, cameras, lights, image sizes. Sorted by any column; the best and the worst of each are marked.

function make_table(some, box, note) {
  const varied = quantities.varied(some), in_views = [...new Set(some.map(entry => entry.view))], keys = view_keys(in_views);
  const axes = [{id: 'metrics', title: 'metrics and costs'}, ...varied.map(one => ({id: 'by ' + one.key, title: one.title, varied: one})),
    ...keys.map(key => ({id: 'view ' + key, title: key === 'size' ? 'image size' : key, key}))];
  const state = {measure: quantities.measures[0]?.id ?? 'visibility', axis: axes[0], metric: null, column: null, descending: false};
  state.metric = quantities.default_error(quantities.of(some, state.measure));

  // A column: {id, title, hint, quantity, entry_of(row)}.
  function columns(all) {
    if (state.axis.id === 'metrics') return all.filter(one => !one.plot_only).map(quantity => ({id: quantity.id, title: quantity.title, hint: quantity.hint, quantity, entry_of: row => row.entry}));
    const quantity = all.find(one => one.id === state.metric) ?? all[0];
    const values = state.axis.varied ? state.axis.varied.values.map(value_text) : [...new Set(in_views.map(view => view[state.axis.key]))];
    return values.map(value => ({id: value, title: value, hint: '', quantity, entry_of: row => row.by.get(value) ?? row.by.get(undefined)}));
  }

  // A row: {entry, label, by: the entry of each column}. What does not depend on the columns' parameter has one entry for all.
  function rows_of(group) {
    if (state.axis.id === 'metrics') return group.map(entry => ({entry, label: entry.name, by: new Map()}));
    const rows = new Map(), key = state.axis.varied?.key;
    for (const entry of group) {
      const others = quantities.others(entry, key), row_key = JSON.stringify([entry.id, others]);
      if (!rows.has(row_key)) rows.set(row_key, {entry, label: entry.title + (others ? ` (${others})` : ''), by: new Map()});
      const at = key ? entry.varied[key] : entry.view[state.axis.key];
      rows.get(row_key).by.set(at === undefined ? undefined : value_text(at), entry);
    }
    return [...rows.values()];
  }

  const value_in = (row, column) => {
    const entry = column.entry_of(row);
    return entry && entry.status !== 'failed' ? column.quantity.value(entry) : undefined;
  };

  function extremes(rows, column) {
    const values = rows.filter(row => !is_reference(row.entry)).map(row => value_in(row, column)).filter(value => value !== undefined);
    const low = Math.min(...values), high = Math.max(...values), {lower} = column.quantity;
    // A mark that half of them share marks nothing.
    const unless_common = value => lower === null || values.filter(one => one === value).length * 2 >= values.length ? null : value;
    return {best: unless_common(lower ? low : high), worst: unless_common(lower ? high : low), high: Math.max(...values.filter(Number.isFinite), 0)};
  }

  function sorted(rows, all) {
    const column = all.find(one => one.id === state.column), sign = state.descending ? -1 : 1;
    const competing = rows.filter(row => !is_reference(row.entry));
    if (state.column === 'name') competing.sort((a, b) => sign * a.label.localeCompare(b.label));
    // What has no value comes last in both directions.
    else if (column) competing.sort((a, b) => {
      const x = value_in(a, column), y = value_in(b, column);
      return x === undefined || y === undefined ? (x === undefined) - (y === undefined) : x === y ? 0 : x < y ? -sign : sign;
    });
    return [...competing, ...rows.filter(row => is_reference(row.entry))];
  }

  function cell(row, column, marks, span) {
    const entry = column.entry_of(row), value = value_in(row, column), made = element('td', {className: 'amount', colSpan: span});
    if (entry?.status === 'failed') {
      made.append(element('span', {className: 'failed', textContent: 'failed', title: entry.message}));
      return made;
    }
    const text = value === undefined ? '–' : column.quantity.text(value), opens = entry && pictured_as(entry) && state.axis.id !== 'metrics';
    const shown = opens ? element('button', {type: 'button', textContent: text, title: 'Show its image'}) : element('span', {textContent: text});
    if (opens) shown.addEventListener('click', () => viewer.open(entry));
    made.append(shown);
    if (value === undefined || is_reference(row.entry)) return made;
    for (const [mark, word] of [['best', 'best'], ['worst', 'worst']])
      if (value === marks[mark]) {
        made.classList.add(mark);
        made.append(element('b', {className: 'mark', role: 'img', 'aria-label': word, title: word}));
      }
    if (Number.isFinite(value) && marks.high > 0) {
      const bar = element('i');
      bar.style.width = `calc((100% - 18px) * ${Math.max(0, value / marks.high)})`;
      made.append(bar);
    }
    return made;
  }

  function body_row(row, all, marks) {
    const number = row.entry.view.shown.indexOf(pictured_as(row.entry)) + 1, pictured = state.axis.id === 'metrics' && number > 0;
    const name = element(pictured ? 'button' : 'span', {className: 'name'}, pictured ? element('span', {className: 'number', textContent: number}) : '', row.label);
    if (pictured) {
      Object.assign(name, {type: 'button', title: 'Show its image'});
      name.addEventListener('click', () => viewer.open(row.entry));
    }
    const kind = is_reference(row.entry) ? 'reference' : row.entry.kind;
    const made = element('tr', {className: is_reference(row.entry) ? 'reference' : ''},
      element('th', {scope: 'row'}, name, ' ', kind ? element('span', {className: 'kind', textContent: kind}) : ''));
    const independent = state.axis.varied && row.by.size === 1 && row.by.has(undefined);
    if (independent) made.append(cell(row, all[0], {}, all.length));
    else made.append(...all.map((column, i) => cell(row, column, marks[i], 1)));
    return made;
  }

  function heading(id, title, hint, lower, span) {
    const button = element('button', {type: 'button', textContent: title, title: hint});
    button.addEventListener('click', () => {
      state.descending = state.column === id ? !state.descending : lower === false;
      state.column = id;
      fill();
      [...box.querySelectorAll('thead button')].find(one => one.textContent === title)?.focus();
    });
    const made = element('th', {scope: 'col', rowSpan: span}, button);
    made.dataset.title = title; // printed in the button's place, which paper would show on its first page alone
    made.setAttribute('aria-sort', state.column !== id ? 'none' : state.descending ? 'descending' : 'ascending');
    return made;
  }

  function head(all) {
    const titles = all.map(column => heading(column.id, column.title, column.hint, column.quantity.lower, 1));
    if (state.axis.id === 'metrics') return element('thead', {}, element('tr', {}, heading('name', 'Technique', '', true, 1), ...titles));
    const over = element('th', {colSpan: all.length, scope: 'colgroup', className: 'over-columns', textContent: `${all[0].quantity.title} by ${state.axis.title}`});
    return element('thead', {}, element('tr', {}, heading('name', 'Technique', '', true, 2), over), element('tr', {}, ...titles));
  }

  function fill() {
    const all = quantities.of(some, state.measure);
    if (!all.length) { box.replaceChildren(); return; }
    const across = columns(all), title_of = entry => view_title(entry.view, keys.filter(key => key !== state.axis.key)), groups = [...new Set(some.map(title_of))];
    const bodies = groups.map(text => {
      const rows = rows_of(some.filter(entry => title_of(entry) === text)), marks = across.map(column => extremes(rows, column));
      const title = groups.length > 1 ? element('tr', {className: 'group'}, element('th', {scope: 'rowgroup', colSpan: across.length + 1, textContent: text})) : '';
      return element('tbody', {}, title, ...sorted(rows, across).map(row => body_row(row, across, marks)));
    });
    box.style.setProperty('--columns', across.length);
    box.replaceChildren(element('caption', {className: 'unseen', textContent: note.dataset.caption}), head(across), ...bodies);
    const on = state.measure === 'visibility' ? 'visibility' : 'the shaded image', truths = new Set(in_views.map(view => view.reference?.title ?? ''));
    note.textContent = (truths.size === 1 && !truths.has('') ? `Errors of ${on} against ${[...truths][0]}. ` : '') +
      `The best of each column${groups.length > 1 ? ' in its group' : ''} is green with a full dot, the worst red with an open one; the bars are relative to the largest value. A click on a title sorts.`;
  }

  // The choices above the table.
  function controls() {
    const measure = element('div', {className: 'segments', role: 'group', 'aria-label': 'Measured on'}), all = quantities.of(some, state.measure);
    const press = segments(measure, quantities.measures, id => { state.measure = id; press(id); fill(); });
    press(state.measure);
    const metric = selection('Values', all.map(one => ({id: one.id, title: one.title})), state.metric, id => { state.metric = id; fill(); });
    const arrange = id => { state.axis = axes.find(axis => axis.id === id) ?? axes[0]; state.column = null; metric.hidden = id === 'metrics'; fill(); };
    const axis = selection('Columns', axes, state.axis.id, arrange);
    const start = report.kind === 'study' ? axes.find(one => one.varied?.numeric) ?? axes.find(one => one.key === 'size') ?? axes[1] ?? axes[0] : axes[0];
    axis.querySelector('select').value = start.id;
    arrange(start.id);
    return [measure, axis, metric];
  }
  return {controls};
}
