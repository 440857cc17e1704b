// The rest of the page, and the start.

const by_id = name => document.getElementById(name);

// A block of entries: its table, then its plots.
function fill_block(name, index) {
  const own = entries.filter(entry => entry.block === index && (report.kind === 'render' || !is_reference(entry)));
  const mark = index ? `-${index + 1}` : '', title = report.kind === 'study' ? name : 'Errors', table = element('table', {className: 'results'});
  const heading = element('h2', {id: 'errors-title' + mark, textContent: title}), note = element('p', {className: 'note'}), choices = element('div', {className: 'axes'});
  note.dataset.caption = title;
  const failed = own.filter(entry => entry.status === 'failed').length;
  choices.append(...make_table(own, table, note).controls());
  by_id('blocks').append(element('section', {id: 'errors' + mark, 'aria-labelledby': heading.id},
    element('div', {className: 'heading'}, heading, choices),
    element('div', {className: 'scroll', tabIndex: 0, role: 'region', 'aria-labelledby': heading.id}, table), note,
    failed ? element('p', {className: 'note failed', textContent: `${failed} of ${own.length} cells failed; “All cells” has their messages.`}) : ''));

  const competing = own.filter(entry => !is_reference(entry)), measure = quantities.measures[0]?.id ?? 'visibility';
  const parameter = quantities.varied(competing).find(one => one.numeric);
  const plots = [parameter && 'by ' + parameter.key, 'texels'].filter(Boolean).map(start => {
    const box = element('figure', {className: 'plot'});
    return competing.length > 1 && make_plot(competing, box, start, measure) ? box : null;
  });
  const plot_title = element('h2', {id: 'cost-title' + mark, textContent: report.kind === 'study' ? `${name}: plots` : 'Error against cost'});
  if (plots.some(Boolean)) by_id('blocks').append(element('section', {id: 'cost' + mark, 'aria-labelledby': plot_title.id}, plot_title, ...plots.filter(Boolean)));
}

// Every cell of a study in one long table, opened on demand.
function fill_cells() {
  by_id('cells').hidden = report.kind !== 'study';
  if (report.kind !== 'study') return;
  const titles = ['Cell', 'Block', 'View', 'Technique', 'Status', 'Time', 'Memory', 'File', 'Parameters'];
  const rows = rivals.map(entry => [element('code', {textContent: entry.cell.slice(0, 12), title: entry.cell}), report.blocks[entry.block] ?? '', entry.view.title, entry.name,
    entry.status === 'failed' ? element('span', {className: 'failed', textContent: 'failed: ' + entry.message}) : entry.status,
    entry.seconds ? seconds(entry.seconds) : '–', entry.peak_bytes ? bytes(entry.peak_bytes) : '–',
    element('span', {}, ...entry.links.map(file_link)), element('span', {className: 'parameters', textContent: Object.entries(entry.parameters).map(([key, value]) => `${key}=${value_text(value)}`).join(', ')})]);
  const list = element('details', {open: rows.length <= 12}, element('summary', {textContent: `${rows.length} cells`}),
    element('div', {className: 'scroll', tabIndex: 0, role: 'region', 'aria-label': 'All cells'}, element('table', {className: 'cells'}, element('thead', {}, element('tr', {}, ...titles.map(textContent => element('th', {scope: 'col', textContent})))),
      element('tbody', {}, ...rows.map(row => element('tr', {}, ...row.map(one => element('td', {}, one))))))));
  by_id('cells').append(list);
}

function fill_words() {
  by_id('title').textContent = report.title;
  pairs(by_id('facts'), report.facts);
  by_id('notes').replaceChildren(...report.notes.map(textContent => element('p', {className: 'note', textContent})));
  const steps = (key, image) => [...new Set(entries.filter(entry => entry[image]).map(entry => entry[key]))].map(level => `1/${level}`).join(' and ');
  by_id('precision').textContent = steps('levels', 'visibility');
  by_id('flip-precision').textContent = steps('flip_levels', 'flip') || '–';
  const rounded = value => +value.toPrecision(6);
  by_id('leak-above').textContent = rounded(report.thresholds.leak_above);
  by_id('false-shadow-below').textContent = rounded(report.thresholds.false_shadow_below);
  by_id('metric-glossary').replaceChildren(...report.metrics.filter(metric => metric.formula).flatMap(metric => [
    element('dt', {textContent: quantities.short_title(metric.id)}),
    element('dd', {textContent: `${metric.title.replace(/^./, letter => letter.toUpperCase())}: ${metric.formula}. From ${metric.range}. Blind to: ${metric.blind_to}.`}),
  ]));
  if (report.links.length) by_id('commands').append(element('h3', {textContent: 'Data'}), element('p', {className: 'links'}, ...report.links.map(file_link)));
  if (report.command_lines.length)
    by_id('commands').append(element('h3', {textContent: 'Made by'}), element('pre', {tabIndex: 0, textContent: report.command_lines.join('\n')}));
}

// Light or dark: as the system says, until the reader says otherwise. A page from disk may have no storage.
const theme = {
  stored() { try { return localStorage.getItem('gnomon-theme'); } catch { return null; } },
  store(value) { try { localStorage.setItem('gnomon-theme', value); } catch { /* only for this visit, then */ } },
  set(value) {
    document.documentElement.dataset.theme = value;
    by_id('theme').setAttribute('aria-pressed', value === 'dark');
  },
};
const prefers_dark = window.matchMedia('(prefers-color-scheme: dark)');
theme.set(theme.stored() ?? (prefers_dark.matches ? 'dark' : 'light'));
prefers_dark.addEventListener('change', event => { if (!theme.stored()) theme.set(event.matches ? 'dark' : 'light'); });
by_id('theme').addEventListener('click', () => {
  const next = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
  theme.set(next);
  theme.store(next);
});

fill_words();
report.blocks.forEach(fill_block);
fill_findings();
fill_cells();
const draw_cards = cards.fill();
for (const link of document.querySelectorAll('nav a')) link.hidden = !document.querySelector(link.getAttribute('href')) || document.querySelector(link.getAttribute('href')).hidden;
viewer.start().then(draw_cards).then(() => { document.documentElement.dataset.ready = 'yes'; });
