// One card an entry that has images: its images, its worst region, its parameters and what it cost.

const cards = (() => {
  const counters = ['draws', 'vertices', 'triangles', 'culled', 'clipped', 'fragments_covered', 'fragments_passed', 'fragments_shaded', 'texels_fetched', 'bytes_read', 'bytes_written', 'rays', 'seconds'];
  const counter_titles = {fragments_covered: 'covered', fragments_passed: 'passed', fragments_shaded: 'shaded', texels_fetched: 'texels', bytes_read: 'read', bytes_written: 'written', target_bytes: 'targets', seconds: 'time'};
  const counter_text = (counter, value) => typeof value !== 'number' ? '–' : counter === 'seconds' ? seconds(value) : counter.includes('bytes') ? bytes(value) : grouped(value);

  function passes(entry) {
    const lines = entry.counters ? [{name: 'all passes', ...entry.counters}] : entry.passes;
    const known = [...new Set([...counters, ...Object.keys(entry.counters ?? {})])];
    const shown = known.filter(counter => lines.some(pass => pass[counter]));
    if (!shown.length) return '';
    const row = (name, get) => element('tr', {}, element('th', {scope: 'row', textContent: name, title: name}),
      ...shown.map(counter => element('td', {textContent: counter_text(counter, get(counter))})));
    return element('div', {className: 'passes', tabIndex: 0, role: 'region', 'aria-label': 'Counters of ' + entry.name}, element('table', {},
      element('thead', {}, element('tr', {}, element('th', {scope: 'col', textContent: 'pass'}), ...shown.map(name => element('th', {scope: 'col', textContent: counter_titles[name] ?? name, title: name})))),
      element('tbody', {}, ...lines.map(pass => row(pass.name, counter => pass[counter]))),
      lines.length > 1 ? element('tfoot', {}, row('total', counter => quantities.counter(entry, counter))) : ''));
  }

  // A small picture of a layer.
  function thumb(entry, layer) {
    const {width, height} = entry.view, small = Math.min(width, 640);
    const canvas = blank(small, Math.max(1, Math.round(small * height / width)));
    const button = element('button', {type: 'button', 'aria-label': `${entry.name}: show ${layer.title.toLowerCase()} in the large panel`}, canvas);
    button.addEventListener('click', () => viewer.open(entry, layer.id));
    const figure = element('figure', {}, button, element('figcaption', {textContent: layer.title}));
    figure.draw = async () => {
      const range = layer.error ? nice_range(await largest_error(entry)) : 1, context = canvas.getContext('2d');
      context.imageSmoothingQuality = 'high';
      context.drawImage(await layer_image(entry, layer.id, range), 0, 0, canvas.width, canvas.height);
      if (!has_bar(layer.id)) return;
      const bar = color_bar(layer.id);
      bar.className = 'bar';
      bar.style.width = '100%';
      figure.append(bar, element('div', {className: 'ends'}, ...range_ends(layer.id, range).map(text => element('span', {textContent: text}))));
    };
    return figure;
  }

  // The square, a twelfth of the image's width, with the largest sum of absolute errors.
  async function worst_region(entry) {
    const [values, truth, mask] = await compared(entry), {width, height} = entry.view;
    const side = Math.max(8, Math.round(width / 12 / 4) * 4), step = side / 4, cols = Math.ceil(width / step), rows = Math.ceil(height / step);
    if (side > width || side > height) return null;
    const sums = new Float64Array(cols * rows);
    for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) {
      const i = y * width + x, error = Math.abs(values[i] - truth[i]);
      if (error < Infinity && in_mask(mask, i)) sums[Math.floor(y / step) * cols + Math.floor(x / step)] += error;
    }
    let best = null;
    for (let r = 0; r * step + side <= height; ++r) for (let c = 0; c * step + side <= width; ++c) {
      let sum = 0;
      for (let j = 0; j < 4; ++j) for (let k = 0; k < 4; ++k) sum += sums[(r + j) * cols + c + k];
      if (!best || sum > best.sum) best = {sum, x: c * step, y: r * step, side};
    }
    return best?.sum > 0 ? best : null;
  }

  async function fill_worst(entry, box) {
    const region = await worst_region(entry);
    if (!region) { box.remove(); return; }
    const range = nice_range(await largest_error(entry)), {reference} = entry.view;
    const crops = await Promise.all([[entry, 'visibility', 'This'], [reference, 'visibility', 'Reference'], [entry, 'signed', 'Signed error']].map(async ([of, layer, caption]) => {
      const canvas = blank(region.side, region.side);
      canvas.getContext('2d').drawImage(await layer_image(of, layer, range), region.x, region.y, region.side, region.side, 0, 0, region.side, region.side);
      return element('figure', {}, canvas, element('figcaption', {textContent: caption}));
    }));
    const link = element('a', {href: '#images', textContent: 'Show it'});
    link.addEventListener('click', event => {
      event.preventDefault();
      viewer.open(entry, 'visibility', {center: [region.x + region.side / 2, region.y + region.side / 2], side: region.side});
    });
    box.replaceChildren(...crops, element('p', {}, `Worst region: ${region.side} × ${region.side} pixels from ${region.x}, ${region.y}. `, link));
  }

  function card(entry) {
    const thumbs = layers.filter(layer => layer.of(entry) && !layer.as_well && !(is_reference(entry) && layer.compares)).map(layer => thumb(entry, layer));
    const worst = has_error(entry) && !is_reference(entry) ? element('div', {className: 'worst-region'}) : '';
    const costs = element('dl', {className: 'costs'}), parameters = Object.entries(entry.parameters);
    pairs(costs, [['Time', entry.seconds ? seconds(entry.seconds) : ''], ['Peak memory', entry.peak_bytes ? bytes(entry.peak_bytes) : ''], ['Passes', entry.passes.length || '']]);
    const made = element('article', {className: 'card'},
      element('header', {}, element('h3', {textContent: entry.name}), element('code', {textContent: entry.id}),
        element('span', {className: 'kind', textContent: is_reference(entry) ? 'reference' : entry.kind, hidden: !is_reference(entry) && !entry.kind}),
        entry.view.title ? element('span', {className: 'note', textContent: entry.view.title}) : '',
        entry.paper ? element('p', {className: 'paper', textContent: entry.paper}) : ''),
      element('div', {className: 'thumbs'}, ...thumbs), worst,
      element('div', {className: 'details'},
        element('div', {}, element('h4', {textContent: 'Parameters'}), parameters.length ? element('dl', {className: 'pairs'}, ...parameters.flatMap(([name, value]) =>
          [element('dt', {textContent: name}), element('dd', {textContent: value_text(value)})])) : element('p', {className: 'note', textContent: 'none'})),
        element('div', {}, element('h4', {textContent: 'Cost'}), costs, passes(entry),
          entry.links.length ? element('p', {className: 'links'}, ...entry.links.map(file_link)) : '')));
    let drawing = null;
    made.draw = () => drawing ??= (async () => {
      for (const one of thumbs) await one.draw();
      if (worst) await fill_worst(entry, worst);
    })();
    return made;
  }

  function fill() {
    const all = entries.filter(entry => entry.shaded || entry.visibility).map(card);
    document.getElementById('cards').replaceChildren(...all);
    document.getElementById('techniques').hidden = !all.length;
    // First the cards near the window, then the rest, so that printing finds all of them.
    const near = new IntersectionObserver(seen => seen.filter(one => one.isIntersecting).forEach(one => { near.unobserve(one.target); one.target.draw(); }), {rootMargin: '600px'});
    all.forEach(one => near.observe(one));
    return async () => { for (const one of all) await one.draw(); };
  }
  return {fill};
})();
