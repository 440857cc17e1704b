// Images, decoded when they are first looked at.

const {width, height} = report;

function blank(w = width, h = height) {
  return element('canvas', {width: w, height: h});
}

async function picture(base64) {
  const image = new Image();
  image.src = 'data:image/png;base64,' + base64;
  await image.decode();
  return image;
}

async function pixels(base64, rows) {
  const canvas = blank(width, rows), context = canvas.getContext('2d', {willReadFrequently: true});
  context.drawImage(await picture(base64), 0, 0);
  return context.getImageData(0, 0, width, rows).data;
}

function remembered(make) {
  const known = new Map();
  return key => {
    if (!known.has(key)) known.set(key, make(key));
    return known.get(key);
  };
}

// 16-bit visibility codes from the two grey planes they are stored in, the top row first.
const codes_of = remembered(async entry => {
  const planes = await pixels(entry.visibility, 2 * height), codes = new Uint16Array(width * height);
  for (let i = 0; i < codes.length; ++i) codes[i] = planes[4 * i] << 8 | planes[4 * (i + codes.length)];
  return codes;
});

const mask_pixels = remembered(async () => report.mask ? await pixels(report.mask, height) : null);
const in_mask = (mask, i) => !mask || mask[4 * i] > 0;
const missing_code = report.visibility_levels + 1;
const value_of = code => code === missing_code ? NaN : code / report.visibility_levels;

// The largest error of an entry among the receivers that count.
const largest_error = remembered(async entry => {
  const [codes, truth, mask] = await Promise.all([codes_of(entry), codes_of(reference), mask_pixels()]);
  let largest = 0;
  for (let i = 0; i < codes.length; ++i)
    if (in_mask(mask, i) && codes[i] !== missing_code && truth[i] !== missing_code)
      largest = Math.max(largest, Math.abs(codes[i] - truth[i]));
  return largest / report.visibility_levels;
});

function nice_range(largest) {
  if (!(largest > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(largest));
  return [1, 2, 2.5, 5, 10].map(step => step * power).find(range => range >= largest * (1 - 1e-6));
}

// 1024 colours of a map as 32-bit pixels, interpolated between its anchors.
const color_table = remembered(name => {
  const anchors = report.color_maps[name], table = new Uint32Array(1024);
  for (let i = 0; i < table.length; ++i) {
    const position = i / (table.length - 1) * (anchors.length - 1), first = Math.min(Math.floor(position), anchors.length - 2);
    const mix = shift => {
      const a = anchors[first] >> shift & 255, b = anchors[first + 1] >> shift & 255;
      return Math.round(a + (b - a) * (position - first));
    };
    table[i] = 0xff000000 | mix(0) << 16 | mix(8) << 8 | mix(16);
  }
  return table;
});

const outside_color = 0xff8c8c8c, missing_color = 0xff4db300;

async function error_canvas(entry, layer, range) {
  const [codes, truth, mask] = await Promise.all([codes_of(entry), codes_of(reference), mask_pixels()]);
  const canvas = blank(), context = canvas.getContext('2d'), image = context.createImageData(width, height);
  const out = new Uint32Array(image.data.buffer), table = color_table(layer), last = table.length - 1;
  const scale = 1 / (range * report.visibility_levels);
  for (let i = 0; i < out.length; ++i) {
    if (!in_mask(mask, i)) { out[i] = outside_color; continue; }
    if (codes[i] === missing_code || truth[i] === missing_code) { out[i] = missing_color; continue; }
    const error = (codes[i] - truth[i]) * scale, t = layer === 'signed' ? 0.5 + 0.5 * error : Math.abs(error);
    out[i] = table[Math.round(Math.min(Math.max(t, 0), 1) * last)];
  }
  context.putImageData(image, 0, 0);
  return canvas;
}

async function visibility_canvas(entry) {
  const codes = await codes_of(entry), canvas = blank(), context = canvas.getContext('2d');
  const image = context.createImageData(width, height), out = new Uint32Array(image.data.buffer);
  for (let i = 0; i < out.length; ++i) {
    const gray = Math.round(codes[i] / report.visibility_levels * 255);
    out[i] = codes[i] === missing_code ? missing_color : 0xff000000 | gray << 16 | gray << 8 | gray;
  }
  context.putImageData(image, 0, 0);
  return canvas;
}

// What a layer of an entry looks like, for drawing: an image or a canvas. The latest dozen are kept.
const drawn = new Map();
function layer_image(entry, layer, range) {
  const key = [entries.indexOf(entry), layer, layer === 'signed' || layer === 'magnitude' ? range : ''].join();
  let image = drawn.get(key);
  drawn.delete(key);
  if (!image) image = layer === 'shaded' ? picture(entry.shaded)
    : layer === 'visibility' ? visibility_canvas(entry) : error_canvas(entry, layer, range);
  drawn.set(key, image);
  if (drawn.size > 12) drawn.delete(drawn.keys().next().value);
  return image;
}

// A colour bar as a strip one pixel high.
function color_bar(layer) {
  const table = color_table(layer), canvas = blank(table.length, 1), context = canvas.getContext('2d');
  const image = context.createImageData(table.length, 1);
  new Uint32Array(image.data.buffer).set(table);
  context.putImageData(image, 0, 0);
  return canvas;
}

const range_ends = (layer, range) => layer === 'signed' ? ['−' + range, '0', '+' + range] : ['0', String(+(range / 2).toPrecision(6)), String(range)];
