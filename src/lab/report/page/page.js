// What the page does beyond showing itself: one scene at a time, tables that sort, plots with readings, bodies that turn.
'use strict';

const all = (what, within = document) => [...within.querySelectorAll(what)];
const root = document.documentElement;
for (const kind of ['error', 'unhandledrejection'])
  addEventListener(kind, event => { root.dataset.errors = (root.dataset.errors || '') + (event.message ?? event.reason) + '; '; });

// --- tables -----------------------------------------------------------------------------------------------------------
function sort_by(head, column) {
  const body = head.closest('table').tBodies[0], falling = head.getAttribute('aria-sort') === 'ascending';
  const key = row => {
    const cell = row.cells[column];
    return cell?.dataset.v !== undefined ? +cell.dataset.v : cell?.textContent ?? '';
  };
  const order = (a, b) => typeof a === 'number' && typeof b === 'number' ? a - b
    : typeof a === 'number' ? -1 : typeof b === 'number' ? 1 : a.localeCompare(b, undefined, {numeric: true});
  body.append(...[...body.rows].sort((a, b) => (falling ? -1 : 1) * order(key(a), key(b))));
  all('th', head.parentElement).forEach(other => other.removeAttribute('aria-sort'));
  head.setAttribute('aria-sort', falling ? 'descending' : 'ascending');
}
all('thead tr').forEach(row => [...row.cells].forEach((head, column) =>
  head.firstElementChild?.addEventListener('click', () => sort_by(head, column))));

/** Lets long names be folded where their words meet. */
function make_foldable(cell) {
  const text = cell.lastChild, words = text?.data?.split(/(?<=[_:])(?=\S)|(?=\+)/) ?? [];
  if (words.length > 1) text.replaceWith(...words.flatMap((word, i) => i ? [document.createElement('wbr'), word] : [word]));
}
all('tbody th, tbody td:not(.n)').forEach(make_foldable);

// --- plots ------------------------------------------------------------------------------------------------------------
const tip = document.body.appendChild(Object.assign(document.createElement('div'), {id: 'tip', role: 'status'}));
/** Shows a text above or below a place on the screen: left, width, top, bottom [px]. */
function show_tip(text, at) {
  tip.textContent = text;
  const box = tip.getBoundingClientRect();
  tip.style.left = Math.max(8, Math.min(innerWidth - box.width - 8, at.left + at.width / 2 - box.width / 2)) + 'px';
  tip.style.top = (at.top - box.height - 10 < 8 ? at.bottom + 10 : at.top - box.height - 10) + 'px';
  tip.style.visibility = 'visible';
}
function hide_tip() { tip.style.visibility = 'hidden'; }
function single_out(section, name) {
  all('svg', section).forEach(svg => {
    const own = all('.series', svg).filter(series => series.dataset.series === name);
    svg.classList.toggle('chosen', own.length > 0);
    all('.series', svg).forEach(series => series.classList.toggle('on', own.includes(series)));
  });
}
all('svg .mark').forEach(mark => {
  mark.querySelector('title').remove();  // its aria-label says the same
  mark.addEventListener('focus', () => show_tip(mark.getAttribute('aria-label'), mark.getBoundingClientRect()));
  mark.addEventListener('blur', hide_tip);
});

/** Shows a run in the body's picture and marks its rows. */
function choose_run(section, name) {
  section.stage?.choose_strategy(name);
  all('tbody tr', section).forEach(row => row.classList.toggle('chosen', row.dataset.series === name));
}
all('.scene').forEach(section => {
  plots_of(section);
  const name_of = target => target.closest('.key, .series')?.dataset.series || target.closest('tbody tr')?.dataset.series;
  section.addEventListener('pointerover', event => single_out(section, name_of(event.target)));
  section.addEventListener('pointerleave', () => single_out(section, undefined));
  section.addEventListener('choose', event => choose_run(section, event.detail));
  all('tbody th', section).forEach(head => head.addEventListener('click', () => choose_run(section, head.parentElement.dataset.series)));
  all('.mark', section).forEach(mark => mark.addEventListener('keydown', event => {
    if (event.key === 'Enter') choose_run(section, mark.closest('.series').dataset.series);
  }));
});

// --- filter of runs ---------------------------------------------------------------------------------------------------
all('.filter').forEach(filter => {
  const rows = all('tbody tr', filter.closest('.card')), part = name => filter.querySelector(`[data-filter="${name}"]`);
  const outcome = part('outcome'), text = part('text');
  const counts = new Map();
  for (const {dataset} of rows) counts.set(dataset.outcome, (counts.get(dataset.outcome) ?? 0) + 1);
  for (const [name, count] of counts) outcome.append(new Option(`${name} (${count})`, name));
  const apply = () => {
    const wanted = text.value.trim().toLowerCase();
    for (const row of rows)
      row.hidden = (outcome.value && row.dataset.outcome !== outcome.value) || !row.dataset.series.toLowerCase().includes(wanted);
    const shown = rows.filter(row => !row.hidden).length;
    part('count').textContent = shown === rows.length ? '' : `${shown} of ${rows.length} runs`;
  };
  outcome.addEventListener('change', apply);
  text.addEventListener('input', apply);
});

function save(name, url) {
  Object.assign(document.createElement('a'), {download: name, href: url}).click();
}
function file_of(svg) {
  const copy = svg.cloneNode(true), style = getComputedStyle(root);
  const colour = name => style.getPropertyValue(name).trim();
  copy.insertAdjacentHTML('afterbegin', `<style>svg{${['--ink', '--faint', '--grid', '--paper'].map(n => `${n}:${colour(n)}`).join(';')};` +
    'background:var(--paper);font-family:system-ui,sans-serif}text{fill:var(--faint)}.axis{fill:var(--ink)}.grid{stroke:var(--grid)}.cross,.frame,.series.off{display:none}.key.off{opacity:.3}</style>');
  return new XMLSerializer().serializeToString(copy);
}
all('button[data-save]').forEach(button => button.addEventListener('click', () => {
  const figure = button.closest('.card'), name = button.dataset.name;
  if (figure.querySelector('.view')) return save(name + '.png', figure.closest('.scene').stage.picture().toDataURL('image/png'));
  const svg = all('svg', figure).find(one => one.getClientRects().length);
  const text = 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(file_of(svg));
  if (button.dataset.save === 'svg') return save(name + '.svg', text);
  const image = new Image();
  image.onload = () => {
    const paper = Object.assign(document.createElement('canvas'), {width: 2 * svg.viewBox.baseVal.width, height: 2 * svg.viewBox.baseVal.height});
    paper.getContext('2d').drawImage(image, 0, 0, paper.width, paper.height);
    save(name + '.png', paper.toDataURL('image/png'));
  };
  image.src = text;
}));

// --- bodies -----------------------------------------------------------------------------------------------------------
/** three, of which one copy lies packed in the page; unpacked when a body is first looked at. */
let three;
function load_three() {
  return three ??= unpacked(document.getElementById('three').textContent).then(text => {
    document.head.append(Object.assign(document.createElement('script'), {textContent: text}));
  });
}

async function stage(section) {
  const packed = all('script.view', section);
  if (!packed.length || !section.querySelector('.view canvas')) return;
  try {
    const [views] = await Promise.all([Promise.all(packed.map(async script => JSON.parse(await unpacked(script.textContent)))), load_three()]);
    const body = body_from(views.find(view => view.kind === 'body')), states = views.filter(view => view.kind === 'states');
    section.stage = new Stage(section, body, new Map(states.map(view => [view.strategy, {frames: states_from(view, body), in_time: view.in_time,
      frequencies: view.frames.map(({frequency}) => frequency)}])));
  } catch (problem) {
    all('.bar > label, .bar > button, .legend, .hint', section.querySelector('.view').parentElement).forEach(part => part.remove());
    section.querySelector('.view').textContent = `No body is drawn here: ${problem.message}. Plots and tables are complete without it.`;
  }
}

// --- scenes -----------------------------------------------------------------------------------------------------------
const scenes = all('.scene[id]'), choice = document.getElementById('scene');
async function go() {
  const wanted = scenes.find(section => '#' + section.id === location.hash) ?? scenes[0];
  scenes.forEach(section => {
    section.hidden = section !== wanted;
    if (section === wanted) return;
    section.stage?.release();
    section.stage = undefined;
  });
  if (choice) choice.value = wanted.id;
  if (wanted && !wanted.stage) await stage(wanted);
}
choice?.addEventListener('change', () => { location.hash = choice.value; });
addEventListener('hashchange', () => { go(); document.getElementById('scene')?.scrollIntoView({block: 'start'}); });
addEventListener('beforeprint', () => all('details').forEach(one => { one.open = true; }));
go().then(() => { root.dataset.ready = 'yes'; });
