'use strict';
// The report's data, and the words and numbers it is shown in. A view is a scene from one camera under one light at one size;
// an entry is what one technique with one set of parameters made of one view, or the reference of the view.

const report = JSON.parse(document.getElementById('report').textContent);
const {entries, views} = report;
const value_text = value => typeof value === 'string' ? value : JSON.stringify(value);

// A view is called by what tells it from the others.
const view_keys = among => ['scene', 'camera', 'light', 'size', 'truth'].filter(key => among.some(view => view[key] !== among[0][key]));
const view_title = (view, keys) => keys.map(key => view[key]).join(', ');
for (const view of views) {
  view.title = view_title(view, view_keys(views));
  view.reference = entries[view.reference];
}
for (const entry of entries) {
  entry.view = views[entry.view];
  const varied = Object.entries(entry.varied).map(([key, value]) => `${key} ${value_text(value)}`).join(', ');
  entry.name = entry.title + (varied ? ` (${varied})` : '');
}
// The entry with the image of this one: itself, or one in another block that is of the same cell.
const with_images = new Map(entries.filter(entry => entry.cell && entry.visibility).map(entry => [entry.cell, entry]));
const pictured_as = entry => entry.shaded || entry.visibility ? entry : with_images.get(entry.cell);
const is_reference = entry => entry === entry.view.reference;
for (const view of views) // those with images, the reference first
  view.shown = entries.filter(entry => entry.view === view && (entry.shaded || entry.visibility)).sort((a, b) => is_reference(b) - is_reference(a));
const rivals = entries.filter(entry => !is_reference(entry));

// What can be shown of an entry. Of those that compare it with the reference, an `error` is in units of visibility and has a
// range to choose; one that shows the same numbers `as_well` as another is not on the cards.
const has_error = entry => Boolean(entry.visibility && entry.view.reference?.visibility);
const has_flip = entry => Boolean(entry.flip) || is_reference(entry) && entries.some(other => other.view === entry.view && other.flip);
const layers = [
  {id: 'shaded', title: 'Shaded', key: 's', of: entry => Boolean(entry.shaded)},
  {id: 'visibility', title: 'Visibility', key: 'v', of: entry => Boolean(entry.visibility)},
  {id: 'signed', title: 'Signed error', key: 'e', of: has_error, compares: true, error: true},
  {id: 'magnitude', title: 'Magnitude', key: 'm', of: has_error, compares: true, error: true},
  {id: 'false-color', title: 'False colours', key: 'c', of: has_error, compares: true, error: true, as_well: 'magnitude'},
  {id: 'flip', title: 'FLIP', key: 'p', of: has_flip, compares: true},
  {id: 'leaks', title: 'Leaks', key: 'l', of: has_error, compares: true},
].filter(layer => entries.some(layer.of));
const layer_of = id => layers.find(layer => layer.id === id);
const is_error_layer = id => Boolean(layer_of(id)?.error), has_bar = id => id in report.color_maps;

function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key in made) made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children.filter(child => child !== null && child !== undefined && child !== ''));
  return made;
}

function pairs(list, rows) {
  list.replaceChildren(...rows.filter(row => row[1] !== '' && row[1] !== undefined)
    .map(([name, value]) => element('div', {}, element('dt', {textContent: name, title: name}), element('dd', {textContent: value}))));
}

// Buttons of which one is pressed.
function segments(box, choices, choose) {
  const buttons = choices.map(choice => {
    const button = element('button', {type: 'button', textContent: choice.title, title: choice.hint ?? ''});
    button.addEventListener('click', () => choose(choice.id));
    return button;
  });
  box.replaceChildren(...buttons);
  box.hidden = choices.length < 2;
  return chosen => buttons.forEach((button, i) => button.setAttribute('aria-pressed', choices[i].id === chosen));
}

// A labelled selection of {id, title}; hidden where there is nothing to choose.
function selection(label, choices, chosen, choose) {
  const box = element('select', {}, ...choices.map(choice => element('option', {value: choice.id, textContent: choice.title})));
  box.value = chosen;
  box.addEventListener('change', () => choose(box.value));
  return element('label', {className: 'field', hidden: choices.length < 2}, label + ' ', box);
}

// A file beside the page. Its name is no address: whatever it holds, it stays a relative path.
const file_link = path => element('a', {href: './' + path.split('/').map(encodeURIComponent).join('/'), textContent: path});

const thin = '\u202f';
const grouped = value => String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, thin);

function compact(value) {
  for (const [unit, size] of [['G', 1e9], ['M', 1e6], ['k', 1e3]])
    if (Math.abs(value) >= size) return (value / size).toPrecision(3) + thin + unit;
  return String(value);
}

function bytes(value) {
  for (const [unit, size] of [['GiB', 2 ** 30], ['MiB', 2 ** 20], ['KiB', 2 ** 10]])
    if (value >= size) return (value / size).toFixed(value / size < 10 ? 2 : value / size < 100 ? 1 : 0) + thin + unit;
  return value + thin + 'B';
}

function seconds(value) {
  if (value >= 100) return Math.round(value) + thin + 's';
  if (value >= 1) return value.toPrecision(3) + thin + 's';
  return value >= 1e-3 ? (value * 1e3).toPrecision(3) + thin + 'ms' : (value * 1e6).toPrecision(3) + thin + 'µs';
}
