// What a study's file asks: tables in a paper's arrangement, and claims that hold or do not.

const findings = report.findings;

function finding_section(id, title, ...content) {
  const section = element('section', {id, 'aria-labelledby': id + '-title'}, element('h2', {id: id + '-title', textContent: title}), ...content);
  by_id('blocks').before(section);
  by_id('nav-study').append(element('a', {href: '#' + id, textContent: title}));
}

// A label that is the one above it is left out for the eye.
function pivot_table(part, name) {
  const rows = part.rows.map((row, i) => element('tr', {},
    ...row.labels.map((label, key) => {
      const above = part.rows[i - 1]?.labels, again = above && row.labels.slice(0, key + 1).every((one, k) => one === above[k]) && key + 1 < row.labels.length;
      return element('th', {scope: 'row', textContent: again ? '' : label, title: label});
    }),
    ...row.texts.map(text => element('td', {className: text === 'failed' ? 'amount failed' : 'amount', textContent: text || '–'}))));
  return element('div', {className: 'scroll', tabIndex: 0, role: 'region', 'aria-label': `${name}: ${part.title}`}, element('table', {className: 'pivot'},
    element('caption', {textContent: part.title}),
    element('thead', {}, element('tr', {}, ...part.keys.map(key => element('th', {scope: 'col', className: 'label', textContent: key.replace(/^parameters\./, '')})),
      ...part.columns.map(textContent => element('th', {scope: 'col', textContent})))),
    element('tbody', {}, ...rows)));
}

function paper_table(table) {
  const [first, ...others] = table.parts;
  return element('details', {open: true}, element('summary', {textContent: table.title ? `${table.name}: ${table.title}` : table.name}),
    table.source ? element('p', {className: 'note', textContent: table.source}) : '', table.note ? element('p', {className: 'note', textContent: table.note}) : '',
    first ? pivot_table(first, table.name) : '',
    others.length ? element('details', {}, element('summary', {textContent: others.map(part => part.title).join(', ')}), ...others.map(part => pivot_table(part, table.name))) : '');
}

const verdict_mark = verdict => element('span', {className: 'verdict ' + verdict.replaceAll(' ', '-'), textContent: verdict});

function claim_card(claim) {
  const checks = claim.checks.map(check => element('tr', {},
    element('td', {}, check.text ? check.text + ': ' : '', element('span', {className: 'formula', textContent: check.formula})),
    element('td', {textContent: check.measured || '–'}), element('td', {}, verdict_mark(check.verdict))));
  return element('details', {className: 'claim', open: claim.verdict !== 'holds'},
    element('summary', {}, element('b', {textContent: claim.id}), ' ' + claim.text + ' ', verdict_mark(claim.verdict)),
    claim.source ? element('p', {className: 'note', textContent: 'Source: ' + claim.source}) : '', claim.note ? element('p', {textContent: claim.note}) : '',
    element('div', {className: 'scroll', tabIndex: 0, role: 'region', 'aria-label': 'Checks of ' + claim.id}, element('table', {className: 'cells'},
      element('thead', {}, element('tr', {}, ...['Check', 'Measured', 'Verdict'].map(textContent => element('th', {scope: 'col', textContent})))), element('tbody', {}, ...checks))));
}

function fill_findings() {
  if (!findings) return;
  document.querySelector('nav').append(element('span', {id: 'nav-study'}));
  if (findings.claims.length) {
    const count = verdict => findings.claims.filter(claim => claim.verdict === verdict).length;
    const words = ['holds', 'holds in part', 'does not hold', 'not measured'].filter(count).map(verdict => `${count(verdict)} ${verdict}`).join(', ');
    finding_section('claims', 'Claims', element('p', {className: 'note', textContent: words}), ...findings.claims.map(claim_card));
  }
  if (findings.tables.length) finding_section('tables', 'Tables', ...findings.tables.map(paper_table));
  if (findings.notes.length) finding_section('study-notes', 'Notes', element('ul', {}, ...findings.notes.map(textContent => element('li', {textContent}))));
}
