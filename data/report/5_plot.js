// Error against cost, one dot a technique; the line joins those that no other beats in both.

const plot = (() => {
  const box = document.getElementById('plot'), x_choice = document.getElementById('plot-x'), y_choice = document.getElementById('plot-y');
  const svg = (name, attributes, ...children) => {
    const made = document.createElementNS(document.querySelector('svg').namespaceURI, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.append(...children);
    return made;
  };
  const costs = ['seconds', 'fragments', 'texels', 'memory'];

  function setup() {
    const all = table.columns();
    const option = column => element('option', {value: column.id, textContent: column.title});
    const errors = all.filter(column => !costs.includes(column.id) && column.lower), charges = all.filter(column => costs.includes(column.id));
    document.getElementById('cost').hidden = !errors.length || !charges.length || table.rivals.length < 2;
    y_choice.replaceChildren(...errors.map(option));
    x_choice.replaceChildren(...charges.map(option));
    if (errors.some(column => column.id === 'rmse')) y_choice.value = 'rmse';
    x_choice.addEventListener('change', draw);
    y_choice.addEventListener('change', draw);
    draw();
  }

  // Powers of ten with 2 and 5 between them where there are few, inside [low, high].
  function log_ticks(low, high) {
    const steps = high / low > 300 ? [1] : [1, 2, 5], ticks = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); ++power)
      for (const step of steps) ticks.push(step * 10 ** power);
    return ticks.filter(tick => tick >= low * 0.999 && tick <= high * 1.001);
  }

  function draw() {
    const all = table.columns(), xs = all.find(c => c.id === x_choice.value), ys = all.find(c => c.id === y_choice.value);
    if (!xs || !ys) return;
    const points = table.rivals.map(entry => ({entry, x: xs.value(entry), y: ys.value(entry)})).filter(p => p.x > 0 && Number.isFinite(p.y));
    if (!points.length) { box.replaceChildren(element('p', {className: 'note', textContent: 'Nothing to plot for this choice.'})); return; }
    const W = 1160, H = 380, left = 64, right = 20, top = 14, bottom = 44;
    const low = Math.min(...points.map(p => p.x)) / 1.5, high = Math.max(...points.map(p => p.x)) * 2.2;
    const least = Math.min(...points.map(p => p.y)), most = Math.max(...points.map(p => p.y)) || 1;
    const log_y = least > 0 && most / least > 30, floor = log_y ? least / 2 : 0, ceiling = log_y ? most * 1.6 : most * 1.12;
    const px = x => left + (W - left - right) * Math.log(x / low) / Math.log(high / low);
    const py = y => H - bottom - (H - bottom - top) * (log_y ? Math.log(y / floor) / Math.log(ceiling / floor) : y / ceiling);
    const parts = [], y_ticks = [];
    if (log_y) y_ticks.push(...log_ticks(floor, ceiling));
    else for (let tick = 0, step = nice_range(ceiling / 5); tick <= ceiling; tick += step) y_ticks.push(tick);
    for (const tick of y_ticks) parts.push(
      svg('line', {class: 'grid', x1: left, x2: W - right, y1: py(tick), y2: py(tick)}),
      svg('text', {x: left - 10, y: py(tick) + 4, 'text-anchor': 'end'}, String(+tick.toPrecision(4))));
    for (const tick of log_ticks(low, high)) parts.push(
      svg('line', {class: 'grid', x1: px(tick), x2: px(tick), y1: top, y2: H - bottom}),
      svg('text', {x: px(tick), y: H - bottom + 18, 'text-anchor': 'middle'}, xs.text(+tick.toPrecision(3)).replace(/\.0+(?=\D|$)/, '')));
    parts.push(svg('text', {x: W - right, y: H - 6, 'text-anchor': 'end'}, `${xs.title}, logarithmic`),
      svg('text', {x: left, y: H - 6}, ys.title + (log_y ? ', logarithmic, upwards' : ', upwards')));

    const front = points.filter(p => !points.some(q => q !== p && q.x <= p.x && q.y <= p.y && (q.x < p.x || q.y < p.y))).sort((a, b) => a.x - b.x);
    parts.push(svg('polyline', {class: 'front', points: front.map(p => `${px(p.x)},${py(p.y)}`).join(' ')}));
    // A label stands right of its dot, or else left, above, below: the first place that is free.
    const taken = points.map(p => [px(p.x) - 6, py(p.y) - 6, px(p.x) + 6, py(p.y) + 6]);
    const is_free = ([l, t, r, b]) => l > left && r < W && b < H - bottom && t > 0 && !taken.some(one => one[0] < r && one[2] > l && one[1] < b && one[3] > t);
    for (const p of points.sort((a, b) => a.y - b.y)) {
      const x = px(p.x), y = py(p.y), long = p.entry.title.length * 6.8;
      const places = [[8, 4, 'start'], [-8, 4, 'end'], [0, -11, 'middle'], [0, 19, 'middle'], [8, -12, 'start'], [-8, -12, 'end'], [8, 20, 'start'], [0, -26, 'middle']];
      const box_of = ([dx, dy, anchor]) => {
        const start = x + dx - (anchor === 'start' ? 0 : anchor === 'end' ? long : long / 2);
        return [start, y + dy - 10, start + long, y + dy + 3];
      };
      const place = places.find(one => is_free(box_of(one))) ?? places[0];
      taken.push(box_of(place));
      const dot = svg('circle', {class: 'dot', cx: x, cy: y, r: 5.5}, svg('title', {}, `${p.entry.title}: ${ys.title} ${ys.text(p.y)}, ${xs.title} ${xs.text(p.x)}`));
      dot.addEventListener('click', () => viewer.open(p.entry, p.entry.visibility ? 'visibility' : 'shaded'));
      parts.push(svg('text', {class: 'label', x: x + place[0], y: y + place[1], 'text-anchor': place[2]}, p.entry.title), dot);
    }
    box.replaceChildren(svg('svg', {viewBox: `0 0 ${W} ${H}`, role: 'img', 'aria-label': `${ys.title} against ${xs.title}`}, ...parts));
  }
  return {setup};
})();
