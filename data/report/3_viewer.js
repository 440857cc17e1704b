// The large panel: two images of one view under one zoom and pan, parted by a wipe or side by side.

const viewer = (() => {
  const id = name => document.getElementById(name);
  const canvas = id('view'), context = canvas.getContext('2d'), stage = id('stage'), handle = id('wipe');
  const pictured = views.filter(view => view.shown.length);
  const state = {view: null, mode: 'wipe', wipe: 0.5, zoom: 1, x: 0, y: 0, range: 'auto', images: [null, null], ranges: [1, 1], pointer: null, cursor: null};
  const left = {entry: null, layer: null}, right = {entry: null, layer: null}, sides = [left, right], names = ['left', 'right'];
  let generation = 0, chips = [];

  // Geometry. `zoom` is relative to the size at which the whole image fits its pane; x and y are the image's point in its middle.
  const panes = () => state.mode === 'side'
    ? [[0, canvas.width / 2], [canvas.width / 2, canvas.width / 2]] : [[0, canvas.width], [0, canvas.width]];
  const scale = () => Math.min(panes()[0][1] / state.view.width, canvas.height / state.view.height) * state.zoom;
  const pane_at = x => state.mode === 'side' ? Number(x >= canvas.width / 2) : state.mode === 'wipe' ? Number(x >= state.wipe * canvas.width) : 0;
  const device = event => {
    const box = canvas.getBoundingClientRect(), ratio = canvas.width / box.width;
    return [(event.clientX - box.left) * ratio, (event.clientY - box.top) * ratio];
  };
  function to_image([x, y]) {
    const [start, size] = panes()[pane_at(x)];
    return [state.x + (x - start - size / 2) / scale(), state.y + (y - canvas.height / 2) / scale()];
  }

  function draw_side(side, [start, size], s) {
    const border = state.wipe * canvas.width;
    context.save();
    context.beginPath();
    if (state.mode !== 'wipe') context.rect(start, 0, size, canvas.height);
    else context.rect(side ? border : 0, 0, side ? canvas.width - border : border, canvas.height);
    context.clip();
    context.imageSmoothingEnabled = s < 1;
    context.imageSmoothingQuality = 'high';
    context.setTransform(s, 0, 0, s, start + size / 2 - state.x * s, canvas.height / 2 - state.y * s);
    context.drawImage(state.images[side], 0, 0, state.view.width, state.view.height);
    if (state.cursor) {
      const [x, y] = state.cursor;
      for (const [color, width] of [['#000', 3], ['#fff', 1]]) {
        context.strokeStyle = color;
        context.lineWidth = width / s;
        context.strokeRect(x - 2 / s, y - 2 / s, 1 + 4 / s, 1 + 4 / s);
      }
    }
    context.restore();
  }

  function draw() {
    if (!state.view) return;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    panes().forEach((pane, side) => {
      if (state.images[side] && (side === 0 || state.mode !== 'single')) draw_side(side, pane, scale());
    });
    if (state.mode === 'side') {
      context.fillStyle = '#000';
      context.fillRect(canvas.width / 2 - 1, 0, 2, canvas.height);
    }
    handle.hidden = state.mode !== 'wipe';
    handle.style.left = state.wipe * 100 + '%';
    handle.setAttribute('aria-valuenow', Math.round(state.wipe * 100));
    handle.setAttribute('aria-valuetext', `${Math.round(state.wipe * 100)} % left`);
  }

  function fit_canvas() {
    if (!state.view) return;
    const ratio = window.devicePixelRatio || 1, box = stage.clientWidth, aspect = state.view.height / state.view.width;
    const tall = state.mode === 'side' ? box / 2 * aspect : box * aspect;
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
      const range = !is_error_layer(side.layer) ? 1 : state.range === 'auto' ? await shared_range() : Number(state.range);
      return [await layer_image(side.entry, side.layer, range), range];
    }));
    if (own !== generation) return;
    state.images = loaded.map(one => one[0]);
    state.ranges = loaded.map(one => one[1]);
    draw();
    legend();
    await read_out();
    stage.dataset.shown = own; // says that what was asked for last is on the screen
  }

  // One range for both sides, so that one colour is one error.
  async function shared_range() {
    const shown = sides.filter(side => is_error_layer(side.layer));
    return nice_range(Math.max(...await Promise.all(shown.map(side => largest_error(side.entry)))));
  }

  // A bar for every colour map that is seen.
  function legend() {
    const maps = new Map(sides.map((side, i) => [side.layer, state.ranges[i]]).filter(([layer]) => has_bar(layer)));
    id('legend').hidden = !maps.size;
    id('legend').replaceChildren(...[...maps].flatMap(([layer, range]) => [color_bar(layer),
      element('div', {className: 'ends'}, ...range_ends(layer, range).map(text => element('span', {textContent: text})))]));
  }

  // The pixel under the pointer, or else under the keyboard's cursor; null outside the image.
  function pixel_at() {
    const [x, y] = state.pointer ? to_image(state.pointer).map(Math.floor) : state.cursor ?? [-1, -1];
    return x >= 0 && y >= 0 && x < state.view.width && y < state.view.height ? [x, y] : null;
  }
  const value_line = value => Number.isFinite(value) ? value.toFixed(5) : Number.isNaN(value) ? 'missing (NaN)' : value < 0 ? 'missing (−∞)' : 'missing (∞)';
  const signed_line = value => (value < 0 ? '−' : '+') + Math.abs(value).toFixed(5);

  async function read_out() {
    const list = id('readout'), view = state.view, reference = view.reference, at = pixel_at();
    const shown = [...new Set([left.entry, ...(state.mode === 'single' ? [] : [right.entry]), reference])].filter(entry => entry?.visibility);
    const values = await Promise.all(shown.map(async entry => at ? (await values_of(entry))[at[1] * view.width + at[0]] : undefined));
    const flips = await Promise.all(shown.map(async entry => at && entry.flip && sides.some(side => side.layer === 'flip') ? (await flip_of(entry))[at[1] * view.width + at[0]] : NaN));
    const mask = await mask_of(view);
    if (String(at) !== String(pixel_at()) || view !== state.view) return; // a later call is on its way
    const truth = reference ? values[shown.indexOf(reference)] : undefined, rows = [['Pixel from top left', at ? `${at[0]}, ${at[1]}` : '–']];
    shown.forEach((entry, k) => {
      const error = values[k] - truth;
      rows.push([entry.name, at ? value_line(values[k]) + (entry !== reference && Number.isFinite(error) ? '  ' + signed_line(error) : '') + (Number.isFinite(flips[k]) ? '  FLIP ' + flips[k].toFixed(3) : '') : '–']);
    });
    if (at && !in_mask(mask, at[1] * view.width + at[0])) rows.push(['Receiver', 'not measured']);
    pairs(list, rows);
  }

  // Controls around the panel.
  const press_mode = segments(id('modes'), [{id: 'wipe', title: 'Wipe'}, {id: 'side', title: 'Side by side'}, {id: 'single', title: 'Left alone'}], set_mode);
  const press_layer = segments(id('layers'), layers, set_layer);
  const view_box = selection('View', pictured.map(view => ({id: views.indexOf(view), title: view.title})), 0, i => { set_view(views[i]); show(); });
  id('view-choice').replaceChildren(view_box);
  id('view-choice').hidden = pictured.length < 2;
  id('range').replaceChildren(...['auto', 1, 0.5, 0.25, 0.1, 0.05, 0.02, 0.01].map(value =>
    element('option', {value, textContent: value === 'auto' ? 'automatic' : '±' + value})));
  id('range').addEventListener('change', event => { state.range = event.target.value; show(); });
  names.forEach((name, side) => {
    id(name + '-layer').replaceChildren(...layers.map(layer => element('option', {value: layer.id, textContent: layer.title})));
    id(name + '-entry').addEventListener('change', event => set_entry(side, Number(event.target.value)));
    id(name + '-layer').addEventListener('change', event => { sides[side].layer = event.target.value; show(); });
  });

  // Another scene, camera or light: the first technique beside the reference, or the same technique as before where it is there.
  function set_view(view) {
    if (state.view === view) return;
    const old = left.entry?.name, rival = view.shown.find(entry => entry.name === old) ?? view.shown.find(entry => !is_reference(entry));
    Object.assign(state, {view, zoom: 1, x: view.width / 2, y: view.height / 2, images: [null, null], cursor: null});
    left.entry = rival ?? view.shown[0];
    right.entry = view.shown.find(is_reference) ?? view.shown.at(-1);
    chips = view.shown.map((entry, i) => {
      const chip = element('button', {type: 'button', title: i < 9 ? `Key ${i + 1}` : ''}, element('span', {className: 'number', textContent: i + 1}), entry.name);
      chip.addEventListener('click', event => set_entry(event.shiftKey ? 1 : 0, i));
      return chip;
    });
    id('chips').replaceChildren(...chips);
    for (const name of names)
      id(name + '-entry').replaceChildren(...view.shown.map((entry, i) => element('option', {value: i, textContent: entry.name})));
    view_box.querySelector('select').value = views.indexOf(view);
    fit_canvas();
  }

  function controls() {
    const shown = state.view.shown;
    for (const side of sides) // an entry may lack the layer that is looked at
      if (!layer_of(side.layer)?.of(side.entry)) side.layer = layers.findLast(layer => layer.of(side.entry) && !layer.compares)?.id;
    press_mode(state.mode);
    press_layer(left.layer === right.layer || state.mode === 'single' ? left.layer : '');
    chips.forEach((chip, i) => chip.setAttribute('aria-pressed', shown[i] === left.entry));
    names.forEach((name, side) => {
      id(name + '-entry').value = shown.indexOf(sides[side].entry);
      id(name + '-layer').value = sides[side].layer;
    });
    stage.querySelector('.tag.right').hidden = state.mode === 'single';
    id('range-field').hidden = !sides.some(side => is_error_layer(side.layer));
    canvas.setAttribute('aria-label', `${left.entry.name}${state.mode === 'single' ? '' : ' beside ' + right.entry.name}; arrows pan, with Shift they move the read-out`);
  }
  function set_mode(mode) { state.mode = mode; fit_canvas(); show(); }
  function set_layer(layer) {
    // The reference's own error is zero everywhere: beside an error map it is more use as it is.
    for (const side of sides) side.layer = is_reference(side.entry) && layer_of(layer).compares ? 'visibility' : layer;
    show();
  }
  function set_entry(side, i) {
    if (!state.view.shown[i]) return;
    sides[side].entry = state.view.shown[i];
    show();
  }
  function step_entry(step) {
    const count = state.view.shown.length;
    set_entry(0, (state.view.shown.indexOf(left.entry) + step + count) % count);
  }
  function swap() {
    [left.entry, right.entry, left.layer, right.layer] = [right.entry, left.entry, right.layer, left.layer];
    show();
  }
  function zoom_by(factor, at = [panes()[0][1] / 2, canvas.height / 2]) {
    const before = to_image(at);
    state.zoom = Math.min(Math.max(state.zoom * factor, 0.5), 64 * Math.max(1, state.view.width / canvas.width));
    const after = to_image(at);
    state.x += before[0] - after[0];
    state.y += before[1] - after[1];
    draw();
    read_out();
  }
  function fit() { state.zoom = 1; state.x = state.view.width / 2; state.y = state.view.height / 2; draw(); read_out(); }
  const one_to_one = () => zoom_by((window.devicePixelRatio || 1) / scale());
  function wipe_to(at) { state.wipe = Math.min(Math.max(at, 0), 1); draw(); }

  // The read-out's cursor, one pixel a step; it begins in the middle of what is seen, and the view follows it.
  function move_cursor([dx, dy]) {
    const limit = (value, size) => Math.min(Math.max(value, 0), size - 1);
    const [x, y] = state.cursor ?? [Math.floor(state.x) - dx, Math.floor(state.y) - dy];
    state.cursor = [limit(x + dx, state.view.width), limit(y + dy, state.view.height)];
    state.pointer = null;
    const half = [panes()[0][1] / 2 / scale(), canvas.height / 2 / scale()];
    state.x = Math.min(Math.max(state.x, state.cursor[0] + 1 - half[0]), state.cursor[0] + half[0]);
    state.y = Math.min(Math.max(state.y, state.cursor[1] + 1 - half[1]), state.cursor[1] + half[1]);
    id('readout').setAttribute('aria-live', 'polite');
    draw();
    read_out();
  }

  // Pointer: drag pans, the wheel zooms about the pointer.
  let drag = null;
  canvas.addEventListener('pointerdown', event => {
    canvas.setPointerCapture(event.pointerId);
    drag = {from: device(event), x: state.x, y: state.y};
    canvas.classList.add('dragging');
  });
  stage.addEventListener('pointermove', event => {
    state.pointer = device(event);
    id('readout').setAttribute('aria-live', 'off');
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
  stage.addEventListener('pointerleave', () => { state.pointer = null; read_out(); });
  canvas.addEventListener('dblclick', fit);
  canvas.addEventListener('wheel', event => {
    event.preventDefault();
    zoom_by(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0016)), device(event));
  }, {passive: false});
  handle.addEventListener('pointerdown', event => handle.setPointerCapture(event.pointerId));
  handle.addEventListener('pointermove', event => {
    if (handle.hasPointerCapture(event.pointerId)) wipe_to(device(event)[0] / canvas.width);
  });

  // Keys.
  const arrows = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
  handle.addEventListener('keydown', event => {
    const step = {ArrowLeft: -0.02, ArrowRight: 0.02, ArrowDown: -0.02, ArrowUp: 0.02, PageDown: -0.1, PageUp: 0.1, Home: -1, End: 1}[event.key];
    if (step) { event.preventDefault(); wipe_to(state.wipe + step); }
  });
  canvas.addEventListener('keydown', event => {
    const step = arrows[event.key];
    if (!step || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    if (event.shiftKey) { move_cursor(step); return; }
    state.x += step[0] * 60 / scale();
    state.y += step[1] * 60 / scale();
    draw();
    read_out();
  });
  const modes = ['wipe', 'side', 'single'];
  const actions = {
    f: fit, '+': () => zoom_by(1.25), '=': () => zoom_by(1.25), '-': () => zoom_by(0.8), x: swap, ',': () => step_entry(-1), '.': () => step_entry(1),
    w: () => set_mode(modes[(modes.indexOf(state.mode) + 1) % 3]), escape: () => { state.cursor = null; draw(); read_out(); },
  };
  document.addEventListener('keydown', event => {
    if (!state.view || event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.('select, input')) return;
    const digit = /^(?:Digit|Numpad)([1-9])$/.exec(event.code), layer = layers.find(one => one.key === event.key.toLowerCase());
    if (digit) set_entry(event.shiftKey ? 1 : 0, Number(digit[1]) - 1);
    else if (layer) set_layer(layer.id);
    else actions[event.key.toLowerCase()]?.();
  });
  id('zoom-in').addEventListener('click', () => zoom_by(1.25));
  id('zoom-out').addEventListener('click', () => zoom_by(0.8));
  id('zoom-fit').addEventListener('click', fit);
  id('zoom-one').addEventListener('click', one_to_one);

  // Brings an entry and one of its layers into the panel, perhaps with a region (centre and side, in pixels) in view.
  function open(wanted, layer = null, region = null) {
    const entry = pictured_as(wanted);
    layer ??= entry.visibility ? 'visibility' : 'shaded';
    set_view(entry.view);
    left.entry = entry;
    left.layer = layer;
    if (entry.view.reference && !is_reference(entry)) Object.assign(right, {entry: entry.view.reference, layer: layer === 'shaded' ? 'shaded' : 'visibility'});
    fit();
    if (region) {
      state.zoom = Math.min(panes()[0][1], canvas.height) / region.side / 2 / scale();
      [state.x, state.y] = region.center;
    }
    stage.scrollIntoView({block: 'center'});
    canvas.focus({preventScroll: true});
    return show();
  }

  async function start() {
    id('images').hidden = !pictured.length;
    if (!pictured.length) return;
    left.layer = right.layer = layers.some(layer => layer.id === 'visibility') ? 'visibility' : layers[0].id;
    set_view(pictured[0]);
    new ResizeObserver(fit_canvas).observe(stage);
    await show();
  }
  return {start, open};
})();
