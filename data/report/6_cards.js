// One card a technique: its images, its worst region, its parameters and what its passes cost.

const cards = (() => {
  const counters = ['draws', 'vertices', 'triangles', 'culled', 'clipped', 'fragments_covered', 'fragments_passed', 'fragments_shaded', 'texels_fetched', 'bytes_read', 'bytes_written', 'seconds'];
  const counter_titles = {fragments_covered: 'covered', fragments_passed: 'passed', fragments_shaded: 'shaded', texels_fetched: 'texels', bytes_read: 'read', bytes_written: 'written', seconds: 'time'};
  const counter_text = (counter, value) => value === undefined ? '–' : counter === 'seconds' ? seconds(value) : counter.startsWith('bytes') ? bytes(value) : grouped(value);

  function passes(entry) {
    if (!entry.passes.length) return '';
    const shown = counters.filter(counter => entry.passes.some(pass => pass[counter]));
    const row = (part, name, get) => element('tr', {}, element('th', {scope: 'row', textContent: name, title: name}),
      ...shown.map(counter => element('td', {textContent: counter_text(counter, get(counter))})));
    return element('div', {className: 'passes'}, element('table', {},
      element('thead', {}, element('tr', {}, element('th', {scope: 'col', textContent: 'pass'}), ...shown.map(c => element('th', {scope: 'col', textContent: counter_titles[c] ?? c, title: c})))),
      element('tbody', {}, ...entry.passes.map(pass => row('td', pass.name, counter => pass[counter]))),
      entry.passes.length > 1 ? element('tfoot', {}, row('td', 'total', counter => total(entry, counter))) : ''));
  }

  // A small picture of a layer.
  function thumb(entry, layer) {
    const canvas = blank(Math.min(width, 640), Math.max(1, Math.round(Math.min(width, 640) * height / width)));
    const button = element('button', {type: 'button', 'aria-label': `${entry.title}: show ${layer.title.toLowerCase()} in the large panel`}, canvas);
    button.addEventListener('click', () => viewer.open(entry, layer.id));
    const figure = element('figure', {}, button, element('figcaption', {textContent: layer.title}));
    figure.draw = async () => {
      const is_error = layer.id === 'signed' || layer.id === 'magnitude', range = is_error ? nice_range(await largest_error(entry)) : 1;
      const context = canvas.getContext('2d');
      context.imageSmoothingQuality = 'high';
      context.drawImage(await layer_image(entry, layer.id, range), 0, 0, canvas.width, canvas.height);
      if (!is_error) return;
      const bar = color_bar(layer.id);
      bar.className = 'bar';
      bar.style.width = '100%';
      figure.append(bar, element('div', {className: 'ends'}, ...range_ends(layer.id, range).map(text => element('span', {textContent: text}))));
    };
    return figure;
  }

  // The square, a twelfth of the image's width, with the largest sum of absolute errors.
  async function worst_region(entry) {
    const [codes, truth, mask] = await Promise.all([codes_of(entry), codes_of(reference), mask_pixels()]);
    const side = Math.max(8, Math.round(width / 12)), step = Math.max(1, side >> 2), cols = Math.ceil(width / step), rows = Math.ceil(height / step);
    if (side > width || side > height) return null;
    const sums = new Float64Array(cols * rows);
    for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) {
      const i = y * width + x;
      if (in_mask(mask, i) && codes[i] !== missing_code && truth[i] !== missing_code)
        sums[(y / step | 0) * cols + (x / step | 0)] += Math.abs(codes[i] - truth[i]);
    }
    let best = null;
    for (let r = 0; r * step + side <= height; ++r) for (let c = 0; c * step + side <= width; ++c) {
      let sum = 0;
      for (let j = 0; j < 4; ++j) for (let k = 0; k < 4; ++k) sum += sums[(r + j) * cols + c + k] || 0;
      if (!best || sum > best.sum) best = {sum, x: c * step, y: r * step, side};
    }
    return best && best.sum > 0 ? best : null;
  }

  async function fill_worst(entry, box) {
    const region = await worst_region(entry);
    if (!region) { box.remove(); return; }
    const range = nice_range(await largest_error(entry));
    const crops = await Promise.all([[entry, 'visibility', entry.title], [reference, 'visibility', reference.title], [entry, 'signed', 'Signed error']].map(async ([of, layer, caption]) => {
      const canvas = blank(region.side, region.side);
      canvas.getContext('2d').drawImage(await layer_image(of, layer, range), region.x, region.y, region.side, region.side, 0, 0, region.side, region.side);
      return element('figure', {}, canvas, element('figcaption', {textContent: caption}));
    }));
    const text = element('p', {}, `Worst region: ${region.side} × ${region.side} pixels from ${region.x}, ${region.y}. `,
      element('a', {href: '#images', textContent: 'Show it'}));
    text.querySelector('a').addEventListener('click', event => {
      event.preventDefault();
      viewer.open(entry, 'visibility', {center: [region.x + region.side / 2, region.y + region.side / 2], side: region.side});
    });
    box.replaceChildren(...crops, text);
  }

  function card(entry) {
    const thumbs = layers.filter(layer => layer.of(entry) && (entry !== reference || !['signed', 'magnitude'].includes(layer.id))).map(layer => thumb(entry, layer));
    const worst = reference && entry !== reference && entry.visibility && reference.visibility ? element('div', {className: 'worst-region'}) : '';
    const parameters = Object.entries(entry.parameters);
    const costs = [['Time', entry.seconds ? seconds(entry.seconds) : ''], ['Peak memory', entry.peak_bytes ? bytes(entry.peak_bytes) : ''], ['Passes', entry.passes.length || '']];
    const cost_list = element('dl', {className: 'costs'});
    pairs(cost_list, costs);
    const made = element('article', {className: 'card'},
      element('header', {}, element('h3', {textContent: entry.title}), element('code', {textContent: entry.id}),
        element('span', {className: 'kind', textContent: entry === reference ? 'reference' : entry.kind}),
        entry.paper ? element('p', {className: 'paper', textContent: entry.paper}) : ''),
      element('div', {className: 'thumbs'}, ...thumbs), worst,
      element('div', {className: 'details'},
        element('div', {}, element('h3', {textContent: 'Parameters'}), parameters.length ? element('dl', {className: 'pairs'}, ...parameters.flatMap(([name, value]) =>
          [element('dt', {textContent: name}), element('dd', {textContent: typeof value === 'string' ? value : JSON.stringify(value)})])) : element('p', {className: 'note', textContent: 'none'})),
        element('div', {}, element('h3', {textContent: 'Cost'}), cost_list, passes(entry),
          entry.links.length ? element('p', {className: 'links'}, ...entry.links.map(link => element('a', {href: link, textContent: link}))) : '')));
    let drawing = null;
    made.draw = () => drawing ??= (async () => {
      for (const one of thumbs) await one.draw();
      if (worst) await fill_worst(entry, worst);
    })();
    return made;
  }

  function fill() {
    const all = entries.map(card);
    document.getElementById('cards').replaceChildren(...all);
    // First the cards near the window, then the rest, so that printing finds all of them.
    const near = new IntersectionObserver(seen => seen.filter(one => one.isIntersecting).forEach(one => { near.unobserve(one.target); one.target.draw(); }), {rootMargin: '600px'});
    all.forEach(one => near.observe(one));
    return async () => { for (const one of all) await one.draw(); };
  }
  return {fill};
})();
