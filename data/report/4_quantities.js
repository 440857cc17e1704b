// What can be tabulated and plotted of an entry: metrics, and what it cost.

const quantities = (() => {
  const short_titles = {mae: 'MAE', mse: 'MSE', rmse: 'RMSE', psnr: 'PSNR', ssim: 'SSIM', ms_ssim: 'MS-SSIM', flip: 'ꟻLIP', max: 'Max'};
  const short_title = id => short_titles[id] ?? id.replaceAll('_', ' ').replace(/^./, letter => letter.toUpperCase());
  const measures = [{id: 'visibility', title: 'Visibility'}, {id: 'shaded', title: 'Shaded'}]
    .filter(measure => entries.some(entry => Object.keys(entry.metrics[measure.id]).length > 0));

  const counter = (entry, name) => {
    if (entry.counters) return entry.counters[name];
    return entry.passes.some(pass => name in pass) ? entry.passes.reduce((sum, pass) => sum + (pass[name] ?? 0), 0) : undefined;
  };
  // JSON has no infinity.
  const metric_value = (entry, measure, id) => {
    const value = entry.metrics[measure][id];
    return value === 'infinite' ? Infinity : value;
  };
  // How the values of one metric are written: with as many decimals as the smallest needs for two digits, so that they line up.
  function metric_text(id, values) {
    const smallest = Math.min(...values.map(Math.abs).filter(value => value > 0 && value < 1), 1);
    const decimals = id === 'psnr' ? 2 : Math.min(Math.max(Math.ceil(-Math.log10(smallest)) + 1, 4), 6);
    return value => value === Infinity ? '∞' : value === 0 ? '0' : Math.abs(value) >= 1000 ? grouped(value) : value.toFixed(decimals);
  }

  const costs = [
    {id: 'texels', title: 'Texels', hint: 'texels fetched in all passes', axis: 'texels fetched', value: entry => counter(entry, 'texels_fetched'), text: compact},
    {id: 'fragments', title: 'Fragments', hint: 'fragments covered in all passes: the fill', axis: 'fragments covered', value: entry => counter(entry, 'fragments_covered'), text: compact},
    {id: 'shading', title: 'Shaded', hint: 'fragments shaded in all passes', axis: 'fragments shaded', value: entry => counter(entry, 'fragments_shaded'), text: compact, plot_only: true},
    {id: 'triangles', title: 'Triangles', hint: 'triangles drawn in all passes', axis: 'triangles drawn', value: entry => counter(entry, 'triangles'), text: compact, plot_only: true},
    {id: 'traffic', title: 'Traffic', hint: 'bytes read and written in all passes', axis: 'bytes read and written', value: entry => {
      const [read, written] = [counter(entry, 'bytes_read'), counter(entry, 'bytes_written')];
      return read === undefined && written === undefined ? undefined : (read ?? 0) + (written ?? 0);
    }, text: bytes, plot_only: true},
    {id: 'memory', title: 'Memory', hint: report.kind === 'study' ? 'the program’s memory at its peak' : 'render targets and scratch memory at their peak', axis: 'peak memory', value: entry => entry.peak_bytes || undefined, text: bytes},
    {id: 'seconds', title: 'Time', hint: 'seconds on the machine that made the images', axis: 'time on the machine that made the images', value: entry => entry.seconds || undefined, text: seconds},
  ];

  // Of some entries: [{id, title, hint, axis, lower: whether less is better (null: unknown), cost, value(entry), text(value)}].
  function of(some, measure) {
    const any = quantity => some.some(entry => quantity.value(entry) !== undefined);
    const metrics = report.metrics.map(metric => {
      const value = entry => metric_value(entry, measure, metric.id);
      return {id: metric.id, title: short_title(metric.id), axis: short_title(metric.id), hint: `${metric.title}: ${metric.formula}`, lower: metric.lower_is_better,
        cost: false, value, text: metric_text(metric.id, some.map(value).filter(one => one !== undefined))};
    });
    return [...metrics, ...costs.map(cost => ({...cost, lower: true, cost: true}))].filter(any);
  }

  // The parameters that the entries vary, each with its distinct values in order.
  function varied(some) {
    const found = new Map();
    for (const entry of some) for (const [key, value] of Object.entries(entry.varied)) {
      if (!found.has(key)) found.set(key, new Map());
      found.get(key).set(value_text(value), value);
    }
    return [...found].filter(([, values]) => values.size > 1).map(([key, values]) => {
      const ordered = [...values.values()], numeric = ordered.every(value => typeof value === 'number');
      if (numeric) ordered.sort((a, b) => a - b);
      const unit = report.parameter_units[key] === key ? '' : report.parameter_units[key] ?? ''; // "samples" says it all
      return {key, values: ordered, numeric, unit, title: key + (unit ? ` (${unit})` : '')};
    });
  }
  // What an entry varies besides `key`, in words.
  const others = (entry, key) => Object.entries(entry.varied).filter(([name]) => name !== key).map(([name, value]) => `${name} ${value_text(value)}`).join(', ');
  const default_error = all => (all.find(one => one.id === 'rmse') ?? all.find(one => !one.cost))?.id;
  return {of, varied, others, measures, short_title, default_error, counter};
})();
