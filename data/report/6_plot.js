// Plots as SVG: axes with round ticks, linear or logarithmic, and series told apart by colour, shape and dash.

const plotting = (() => {
  const svg = (name, attributes, ...children) => {
    const made = document.createElementNS(document.querySelector('svg').namespaceURI, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.append(...children);
    return made;
  };

  // Powers of ten with 2 and 5 between them where there are few, inside [low, high].
  function log_ticks(low, high) {
    const steps = high / low > 300 ? [1] : [1, 2, 5], ticks = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); ++power)
      for (const step of steps) ticks.push(+(step * 10 ** power).toPrecision(6));
    return ticks.filter(tick => tick >= low * 0.999 && tick <= high * 1.001);
  }

  function linear_ticks(low, high) {
    const step = nice_range((high - low) / 6), ticks = [];
    for (let i = Math.ceil(low / step - 1e-6); i * step <= high * (1 + 1e-9); ++i) ticks.push(+(i * step).toPrecision(6));
    return ticks;
  }

  // An axis over values: {log, low, high, at(value): 0 to 1, ticks, text}. On a logarithmic one zero has a place of its own
  // before all others.
  function axis(all, {log, pad = [1, 1], from_zero = false, ticks = null, text}) {
    const values = log ? all.filter(value => value > 0) : all, zero = values.length < all.length ? 0.08 : 0;
    if (!values.length) values.push(1);
    const least = Math.min(...values), most = Math.max(...values), spread = most - least || Math.abs(most) || 1;
    const low = log ? least / pad[0] : from_zero ? Math.min(0, least) : least - spread * 0.06;
    const high = log ? most * pad[1] : most + spread * 0.08;
    const at = log ? value => value > 0 ? zero + (1 - zero) * Math.log(value / low) / Math.log(high / low) : zero / 3 : value => (value - low) / (high - low);
    const round = ticks ?? (log ? log_ticks(low, high) : linear_ticks(low, high));
    return {log, low, high, at, text, ticks: zero ? [0, ...round] : round};
  }

  // Eight shapes around 0, 0 that differ even without colour.
  const shapes = [
    'M5.5 0A5.5 5.5 0 1 1-5.5 0A5.5 5.5 0 1 1 5.5 0Z', 'M-5-5H5V5H-5Z', 'M0-6.5L6 5H-6Z', 'M0-7L6 0L0 7L-6 0Z', 'M0 6.5L6-5H-6Z',
    'M-2-6H2V-2H6V2H2V6H-2V2H-6V-2H-2Z', 'M-6-3.5L-3.5-6L0-2.5L3.5-6L6-3.5L2.5 0L6 3.5L3.5 6L0 2.5L-3.5 6L-6 3.5L-2.5 0Z',
    'M0-7L1.8-2.2L7-2L2.9 1.2L4.3 6.2L0 3.3L-4.3 6.2L-2.9 1.2L-7-2L-1.8-2.2Z',
  ];
  const marker = (index, attributes = {}, ...children) => svg('path', {class: `dot c${index % 8}`, d: shapes[(index + (index / 8 | 0)) % 8], ...attributes}, ...children);

  function legend(series, lines) {
    return element('ul', {className: 'series'}, ...series.map((one, i) => element('li', {},
      svg('svg', {viewBox: '-16 -8 32 16', width: 32, height: 16, 'aria-hidden': 'true'},
        ...(lines ? [svg('path', {class: `line c${i % 8} d${(i / 8 | 0) % 3}`, d: 'M-16 0H16'})] : []), marker(i)), one.title)));
  }

  // Arrow keys go from point to point; Tab passes the plot in one step.
  function walk(points) {
    points.forEach((point, i) => {
      point.setAttribute('tabindex', i ? -1 : 0);
      point.addEventListener('keydown', event => {
        const step = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key], next = points[(i + step + points.length) % points.length];
        if (event.key === 'Enter' || event.key === ' ') point.dispatchEvent(new MouseEvent('click'));
        else if (!step) return;
        event.preventDefault();
        event.stopPropagation();
        if (step) next.focus();
      });
    });
  }

  // A label stands right of its dot, or else left, above, below: the first place that is free.
  function labels(points, {left, right, top, bottom}) {
    const taken = points.map(p => [p.px - 6, p.py - 6, p.px + 6, p.py + 6]);
    const is_free = ([l, t, r, b]) => l > left && r < right && b < bottom && t > top && !taken.some(one => one[0] < r && one[2] > l && one[1] < b && one[3] > t);
    return [...points].sort((a, b) => a.y - b.y).map(p => {
      const long = p.entry.name.length * 6.8;
      const places = [[9, 4, 'start'], [-9, 4, 'end'], [0, -11, 'middle'], [0, 19, 'middle'], [8, -12, 'start'], [-8, -12, 'end'], [8, 20, 'start'], [0, -26, 'middle']];
      const box_of = ([dx, dy, anchor]) => {
        const start = p.px + dx - (anchor === 'start' ? 0 : anchor === 'end' ? long : long / 2);
        return [start, p.py + dy - 10, start + long, p.py + dy + 3];
      };
      const place = places.find(one => is_free(box_of(one))) ?? places[0];
      taken.push(box_of(place));
      return svg('text', {class: 'label', x: p.px + place[0], y: p.py + place[1], 'text-anchor': place[2]}, p.entry.name);
    });
  }

  // Points that no other beats in both, from left to right.
  function front(points, lower) {
    const beats = (q, p) => q.x <= p.x && (lower ? q.y <= p.y : q.y >= p.y) && (q.x < p.x || q.y !== p.y);
    return points.filter(p => !points.some(q => beats(q, p))).sort((a, b) => a.x - b.x);
  }

  // One diagram. `series`: [{title, points: [{x, y, entry}]}].
  function diagram({title, series, x, y, x_title, y_title, lines, lower, direct, guide, width, height}) {
    const area = {left: 68, right: width - 20, top: title ? 34 : 16, bottom: height - 50}, parts = [], dots = [];
    const px = value => area.left + (area.right - area.left) * x.at(value), py = value => area.bottom - (area.bottom - area.top) * y.at(value);
    for (const tick of y.ticks) parts.push(svg('line', {class: 'grid', x1: area.left, x2: area.right, y1: py(tick), y2: py(tick)}),
      svg('text', {x: area.left - 9, y: py(tick) + 4, 'text-anchor': 'end'}, y.text(tick)));
    for (const tick of x.ticks) parts.push(svg('line', {class: 'grid', x1: px(tick), x2: px(tick), y1: area.top, y2: area.bottom}),
      svg('text', {x: px(tick), y: area.bottom + 18, 'text-anchor': 'middle'}, x.text(tick)));
    parts.push(svg('path', {class: 'axis', d: `M${area.left} ${area.top}V${area.bottom}H${area.right}`}),
      svg('text', {class: 'title', x: (area.left + area.right) / 2, y: height - 10, 'text-anchor': 'middle'}, x_title + (x.log ? ', logarithmic' : '')),
      svg('text', {class: 'title', transform: `translate(15 ${(area.top + area.bottom) / 2}) rotate(-90)`, 'text-anchor': 'middle'}, y_title + (y.log ? ', logarithmic' : '')));
    if (title) parts.push(svg('text', {class: 'heading', x: area.left, y: 20}, title));
    const path = points => 'M' + points.map(p => `${px(p.x).toFixed(1)} ${py(p.y).toFixed(1)}`).join('L');
    if (guide) parts.push(svg('path', {class: 'guide', d: path(guide.points)}), svg('text', {x: px(guide.points[1].x) - 6, y: py(guide.points[1].y) - 8, 'text-anchor': 'end'}, guide.title));
    const all = series.flatMap(one => one.points);
    const steps = points => points.map((p, i) => i ? `H${px(p.x).toFixed(1)}V${py(p.y).toFixed(1)}` : `M${px(p.x).toFixed(1)} ${py(p.y).toFixed(1)}`).join('');
    if (!lines) parts.push(svg('path', {class: 'front', d: steps(front(all.filter(p => p.x > 0), lower))}));
    series.forEach((one, i) => {
      if (lines && one.points.length > 1) parts.push(svg('path', {class: `line c${i % 8} d${(i / 8 | 0) % 3}`, d: path(one.points)}));
      for (const p of one.points) {
        [p.px, p.py] = [px(p.x), py(p.y)];
        const words = `${p.entry.name}: ${y_title} ${p.y_text}, ${x_title} ${p.x_text}`, opens = Boolean(pictured_as(p.entry));
        const dot = marker(i, {transform: `translate(${p.px.toFixed(1)} ${p.py.toFixed(1)})`, role: opens ? 'button' : 'img', 'aria-label': words}, svg('title', {}, words));
        if (opens) dot.addEventListener('click', () => viewer.open(p.entry));
        dots.push(dot);
      }
    });
    if (direct) parts.push(...labels(all, area));
    walk(dots);
    return svg('svg', {viewBox: `0 0 ${width} ${height}`, role: 'group', 'aria-label': `${title ? title + ': ' : ''}${y_title} against ${x_title}`}, ...parts, ...dots);
  }
  return {axis, diagram, legend};
})();
