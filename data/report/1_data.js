'use strict';
// The report's data, and the words and numbers it is shown in.

const report = JSON.parse(document.getElementById('report').textContent);
const entries = report.entries;
const reference = entries[report.reference];

const layers = [
  {id: 'shaded', title: 'Shaded', key: 's', of: e => e.shaded !== ''},
  {id: 'visibility', title: 'Visibility', key: 'v', of: e => e.visibility !== ''},
  {id: 'signed', title: 'Signed error', key: 'e', of: e => e.visibility !== '' && reference?.visibility},
  {id: 'magnitude', title: 'Magnitude', key: 'm', of: e => e.visibility !== '' && reference?.visibility},
].filter(layer => entries.some(layer.of));

function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key in made && key !== 'list') made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children.filter(child => child !== null && child !== undefined && child !== ''));
  return made;
}

function pairs(list, rows) {
  list.replaceChildren(...rows.filter(row => row[1] !== '' && row[1] !== undefined)
    .map(([name, value]) => element('div', {}, element('dt', {textContent: name}), element('dd', {textContent: value}))));
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

// How the values of one metric are written: with as many decimals as the smallest needs for two digits, so that they line up.
function metric_text(id, values) {
  const smallest = Math.min(...values.map(Math.abs).filter(value => value > 0 && value < 1), 1);
  const decimals = id === 'psnr' ? 2 : Math.min(Math.max(Math.ceil(-Math.log10(smallest)) + 1, 4), 6);
  return value => value === undefined ? '–' : value === Infinity ? '∞' : value === 0 ? '0' : value.toFixed(decimals);
}

const metric_value = (entry, measure, id) => {
  const value = entry.metrics[measure][id];
  return value === 'infinite' ? Infinity : value;
};

const total = (entry, counter) => entry.passes.some(pass => counter in pass)
  ? entry.passes.reduce((sum, pass) => sum + (pass[counter] ?? 0), 0) : undefined;
