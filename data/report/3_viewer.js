// The large panel: two images under one view, parted by a wipe or side by side.

const viewer = (() => {
  const id = name => document.getElementById(name);
  const canvas = id('view'), context = canvas.getContext('2d'), stage = id('stage'), handle = id('wipe');
  const first_other = Math.max(0, entries.findIndex(entry => entry !== reference));
  const start_layer = layers.find(layer => layer.id === 'visibility') ?? layers[0];
  const state = {
    left: {entry: entries[first_other], layer: start_layer?.id}, right: {entry: reference ?? entries.at(-1), layer: start_layer?.id},
    mode: 'wipe', wipe: 0.5, zoom: 1, x: width / 2, y: height / 2, range: 'auto', images: [null, null], ranges: [1, 1], pointer: null,
  };
  const sides = [state.left, state.right], names = ['left', 'right'];
  let generation = 0;

  // Geometry. `zoom` is relative to the size at which the whole image fits its pane.
  const panes = () => state.mode === 'side'
    ? [[0, canvas.width / 2], [canvas.width / 2, canvas.width / 2]] : [[0, canvas.width], [0, canvas.width]];
  const scale = () => Math.min(panes()[0][1] / width, canvas.height / height) * state.zoom;
  const pane_at = x => state.mode === 'side' ? Number(x >= canvas.width / 2) : state.mode === 'wipe' ? Number(x >= state.wipe * canvas.width) : 0;
  const device = event => {
    const box = canvas.getBoundingClientRect(), ratio = canvas.width / box.width;
    return [(event.clientX - box.left) * ratio, (event.clientY - box.top) * ratio];
  };
  function to_image([x, y]) {
    const [left, size] = panes()[pane_at(x)];
    return [state.x + (x - left - size / 2) / scale(), state.y + (y - canvas.height / 2) / scale()];
  }

  function draw() {
    const s = scale();
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    panes().forEach(([left, size], side) => {
      if (!state.images[side] || (side === 1 && state.mode === 'single')) return;
      const border = state.wipe * canvas.width;
      context.save();
      context.beginPath();
      if (state.mode !== 'wipe') context.rect(left, 0, size, canvas.height);
      else context.rect(side ? border : 0, 0, side ? canvas.width - border : border, canvas.height);
      context.clip();
      context.imageSmoothingEnabled = s < 1;
      context.imageSmoothingQuality = 'high';
      context.setTransform(s, 0, 0, s, left + size / 2 - state.x * s, canvas.height / 2 - state.y * s);
      context.drawImage(state.images[side], 0, 0);
      context.restore();
    });
    if (state.mode === 'side') {
      context.fillStyle = '#000';
      context.fillRect(canvas.width / 2 - 1, 0, 2, canvas.height);
    }
    handle.hidden = state.mode !== 'wipe';
    handle.style.left = state.wipe * 100 + '%';
    handle.setAttribute('aria-valuenow', Math.round(state.wipe * 100));
  }

  function fit_canvas() {
    const ratio = window.devicePixelRatio || 1, box = stage.clientWidth;
    const tall = state.mode === 'side' ? box / 2 * height / width : box * height / width;
    const css_height = Math.round(Math.max(240, Math.min(tall, window.innerHeight * 0.82)));
    canvas.style.height = css_height + 'px';
    canvas.width = Math.round(box * ratio);
    canvas.height = Math.round(css_height * ratio);
    draw();
  }

  // Loads what the two sides show; an older, slower load never overtakes a newer one.
  async function show() {
    const own = ++generation;
    controls();
    const loaded = await Promise.all(sides.map(async side => {
      if (!side.layer) return [null, 1];
      const is_error = side.layer === 'signed' || side.layer === 'magnitude';
      const range = !is_error ? 1 : state.range === 'auto' ? await shared_range() : Number(state.range);
      return [await layer_image(side.entry, side.layer, range), range];
    }));
    if (own !== generation) return;
    state.images = loaded.map(one => one[0]);
    state.ranges = loaded.map(one => one[1]);
    draw();
    legend();
    read_out();
  }

  // One range for both sides, so that one colour is one error.
  async function shared_range() {
    const shown = sides.filter(side => side.layer === 'signed' || side.layer === 'magnitude');
    return nice_range(Math.max(...await Promise.all(shown.map(side => largest_error(side.entry)))));
  }

  function legend() {
    const side = sides.findIndex(s => s.layer === 'signed' || s.layer === 'magnitude');
    id('legend').hidden = side < 0;
    if (side < 0) return;
    const layer = sides[side].layer;
    id('legend').replaceChildren(color_bar(layer),
      element('div', {className: 'ends'}, ...range_ends(layer, state.ranges[side]).map(text => element('span', {textContent: text}))));
  }

  async function read_out() {
    const list = id('readout'), signed = value => (value < 0 ? '−' : '+') + Math.abs(value).toFixed(5);
    const text = value => Number.isNaN(value) ? 'missing' : value.toFixed(5);
    let at = null;
    if (state.pointer) {
      const [x, y] = to_image(state.pointer).map(Math.floor);
      if (x >= 0 && y >= 0 && x < width && y < height) at = [x, y];
    }
    const shown = [...new Set([...(state.mode === 'single' ? [state.left] : sides).map(side => side.entry), reference])]
      .filter(entry => entry?.visibility);
    const rows = [['Pixel from top left', at ? `${at[0]}, ${at[1]}` : '–']];
    if (!at) {
      pairs(list, rows.concat(shown.map(entry => [entry.title, '–'])));
      return;
    }
    const i = at[1] * width + at[0], values = await Promise.all(shown.map(async entry => value_of((await codes_of(entry))[i])));
    const truth = reference?.visibility ? value_of((await codes_of(reference))[i]) : NaN;
    shown.forEach((entry, k) => rows.push([entry.title,
      text(values[k]) + (entry !== reference && !Number.isNaN(values[k] - truth) ? '  ' + signed(values[k] - truth) : '')]));
    if (!in_mask(await mask_pixels(), i)) rows.push(['Receiver', 'not measured']);
    pairs(list, rows);
  }

  // Controls around the panel.
  const press_mode = segments(id('modes'), [{id: 'wipe', title: 'Wipe'}, {id: 'side', title: 'Side by side'}, {id: 'single', title: 'Left alone'}], set_mode);
  const press_layer = segments(id('layers'), layers, set_layer);
  const chips = entries.map((entry, i) => {
    const chip = element('button', {type: 'button', title: i < 9 ? `Key ${i + 1}` : ''}, element('span', {className: 'number', textContent: i + 1}), entry.title);
    chip.addEventListener('click', event => set_entry(event.shiftKey ? 1 : 0, i));
    return chip;
  });
  id('chips').replaceChildren(...chips);
  id('range').replaceChildren(...['auto', 1, 0.5, 0.25, 0.1, 0.05, 0.02, 0.01].map(value =>
    element('option', {value, textContent: value === 'auto' ? 'automatic' : '±' + value})));
  id('range').addEventListener('change', event => { state.range = event.target.value; show(); });
  names.forEach((name, side) => {
    const entry_box = id(name + '-entry'), layer_box = id(name + '-layer');
    entry_box.replaceChildren(...entries.map((entry, i) => element('option', {value: i, textContent: entry.title})));
    layer_box.replaceChildren(...layers.map(layer => element('option', {value: layer.id, textContent: layer.title})));
    entry_box.addEventListener('change', () => set_entry(side, Number(entry_box.value)));
    layer_box.addEventListener('change', () => { sides[side].layer = layer_box.value; show(); });
  });

  function controls() {
    for (const side of sides) // an entry may lack the layer that is looked at
      if (!layers.find(layer => layer.id === side.layer)?.of(side.entry)) side.layer = layers.find(layer => layer.of(side.entry))?.id;
    press_mode(state.mode);
    press_layer(state.left.layer === state.right.layer || state.mode === 'single' ? state.left.layer : '');
    chips.forEach((chip, i) => chip.setAttribute('aria-pressed', entries[i] === state.left.entry));
    names.forEach((name, side) => {
      id(name + '-entry').value = entries.indexOf(sides[side].entry);
      id(name + '-layer').value = sides[side].layer;
    });
    stage.querySelector('.tag.right').hidden = state.mode === 'single';
    id('range-field').hidden = !sides.some(side => side.layer === 'signed' || side.layer === 'magnitude');
  }
  function set_mode(mode) { state.mode = mode; fit_canvas(); show(); }
  function set_layer(layer) {
    // The reference's own error is zero everywhere: beside an error map it is more use as it is.
    for (const side of sides) side.layer = side.entry === reference && (layer === 'signed' || layer === 'magnitude') ? 'visibility' : layer;
    show();
  }
  function set_entry(side, i) {
    if (!entries[i]) return;
    sides[side].entry = entries[i];
    show();
  }
  function zoom_by(factor, at = [panes()[0][1] / 2, canvas.height / 2]) {
    const before = to_image(at);
    state.zoom = Math.min(Math.max(state.zoom * factor, 0.5), 64 * Math.max(1, width / canvas.width));
    const after = to_image(at);
    state.x += before[0] - after[0];
    state.y += before[1] - after[1];
    draw();
    read_out();
  }
  function fit() { state.zoom = 1; state.x = width / 2; state.y = height / 2; draw(); read_out(); }
  const one_to_one = () => zoom_by((window.devicePixelRatio || 1) / scale());

  // Pointer: drag pans, the wheel zooms about the pointer.
  let drag = null;
  canvas.addEventListener('pointerdown', event => {
    canvas.setPointerCapture(event.pointerId);
    drag = {from: device(event), x: state.x, y: state.y};
    canvas.classList.add('dragging');
  });
  canvas.addEventListener('pointermove', event => {
    state.pointer = device(event);
    if (drag) {
      state.x = drag.x - (state.pointer[0] - drag.from[0]) / scale();
      state.y = drag.y - (state.pointer[1] - drag.from[1]) / scale();
      draw();
    }
    read_out();
  });
  const drop = () => { drag = null; canvas.classList.remove('dragging'); };
  canvas.addEventListener('pointerup', drop);
  canvas.addEventListener('pointercancel', drop);
  canvas.addEventListener('pointerleave', () => { state.pointer = null; read_out(); });
  canvas.addEventListener('dblclick', fit);
  canvas.addEventListener('wheel', event => {
    event.preventDefault();
    zoom_by(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0016)), device(event));
  }, {passive: false});
  handle.addEventListener('pointerdown', event => handle.setPointerCapture(event.pointerId));
  handle.addEventListener('pointermove', event => {
    if (handle.hasPointerCapture(event.pointerId)) wipe_to(device(event)[0] / canvas.width);
  });
  function wipe_to(at) { state.wipe = Math.min(Math.max(at, 0), 1); draw(); }

  handle.addEventListener('keydown', event => {
    const step = {ArrowLeft: -0.02, ArrowRight: 0.02, Home: -1, End: 1}[event.key];
    if (step) { event.preventDefault(); wipe_to(state.wipe + step); }
  });
  canvas.addEventListener('keydown', event => {
    const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
    if (!step) return;
    event.preventDefault();
    state.x += step[0] * 60 / scale();
    state.y += step[1] * 60 / scale();
    draw();
  });
  document.addEventListener('keydown', event => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.('select, input')) return;
    const digit = /^(?:Digit|Numpad)([1-9])$/.exec(event.code), layer = layers.find(one => one.key === event.key.toLowerCase());
    const modes = ['wipe', 'side', 'single'];
    const actions = {
      f: fit, '+': () => zoom_by(1.25), '=': () => zoom_by(1.25), '-': () => zoom_by(0.8),
      w: () => set_mode(modes[(modes.indexOf(state.mode) + 1) % 3]),
      x: () => { [state.left.entry, state.right.entry] = [state.right.entry, state.left.entry]; [state.left.layer, state.right.layer] = [state.right.layer, state.left.layer]; show(); },
    };
    if (digit) set_entry(event.shiftKey ? 1 : 0, Number(digit[1]) - 1);
    else if (layer) set_layer(layer.id);
    else actions[event.key.toLowerCase()]?.();
  });
  id('zoom-in').addEventListener('click', () => zoom_by(1.25));
  id('zoom-out').addEventListener('click', () => zoom_by(0.8));
  id('zoom-fit').addEventListener('click', fit);
  id('zoom-one').addEventListener('click', one_to_one);
  new ResizeObserver(fit_canvas).observe(stage);

  // Brings an entry and one of its layers into the panel, perhaps with a region (centre and side, in pixels) in view.
  function open(entry, layer, region) {
    state.left.entry = entry;
    state.left.layer = layer;
    if (reference && entry !== reference) state.right = Object.assign(sides[1], {entry: reference, layer: layer === 'shaded' ? 'shaded' : 'visibility'});
    fit();
    if (region) {
      state.zoom = Math.min(panes()[0][1], canvas.height) / region.side / 2 / scale();
      [state.x, state.y] = region.center;
    }
    show();
    stage.scrollIntoView({block: 'center'});
    canvas.focus({preventScroll: true});
  }
  return {show, fit_canvas, open};
})();
