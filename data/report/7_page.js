// The rest of the page, and the start.

document.getElementById('title').textContent = report.title;
pairs(document.getElementById('facts'), [
  ['Scene', report.scene], ['Camera', report.camera], ['Light', report.light],
  ['Images', width ? `${width} × ${height} pixels` : ''],
  ['Techniques', String(table.rivals.length)], ['Reference', reference?.title ?? 'none'],
]);
document.getElementById('metric-glossary').replaceChildren(...report.metrics.flatMap(metric => [
  element('dt', {textContent: table.short_title(metric.id)}),
  element('dd', {textContent: `${metric.title[0].toUpperCase()}${metric.title.slice(1)}: ${metric.formula}. From ${metric.range}. Blind to: ${metric.blind_to}.`}),
]));
if (report.command_lines.length)
  document.getElementById('commands').replaceChildren(element('h3', {textContent: 'Made by'}), element('pre', {textContent: report.command_lines.join('\n')}));

// Light or dark: as the system says, until the reader says otherwise. A page from disk may have no storage.
const theme = {
  stored() { try { return localStorage.getItem('gnomon-theme'); } catch { return null; } },
  store(value) { try { localStorage.setItem('gnomon-theme', value); } catch { /* only for this visit, then */ } },
  set(value) { document.documentElement.dataset.theme = value; },
};
const prefers_dark = window.matchMedia('(prefers-color-scheme: dark)');
theme.set(theme.stored() ?? (prefers_dark.matches ? 'dark' : 'light'));
prefers_dark.addEventListener('change', event => { if (!theme.stored()) theme.set(event.matches ? 'dark' : 'light'); });
document.getElementById('theme').addEventListener('click', () => {
  const next = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
  theme.set(next);
  theme.store(next);
});

table.fill();
plot.setup();
const draw_cards = cards.fill();
if (layers.length) {
  viewer.fit_canvas();
  viewer.show().then(draw_cards);
} else document.getElementById('images').hidden = true;
