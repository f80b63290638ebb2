// Puts the page together (base.js has what it shows).
'use strict';

function certificate() {
  const rows = [];
  runs.forEach((run, i) => {
    for (const promise of run.expect || []) {
      rows.push([...(several ? [make('span', {}, key(i), run.label)] : []), promise.key,
        promise.key === 'all_converged' ? 'true' : shown(promise.limit, promise.unit),
        promise.worst === undefined ? '–' : make('span', {}, shown(promise.worst, promise.unit) + ' in ', frameLink(promise.worst_frame, 'frame ' + promise.worst_frame)),
        promise.holds ? ['holds', 'good'] : [make('span', {}, 'broken from ', frameLink(promise.first_broken_frame, 'frame ' + promise.first_broken_frame), ' on'), 'bad']]);
    }
  });
  return rows.length ? table([...(several ? ['run'] : []), 'expected', 'limit', 'worst', ''], rows)
    : make('p', {class: 'faint'}, several ? 'The scenes expect nothing of themselves: no [expect] table.' : 'The scene expects nothing of itself: no [expect] table.');
}

function showRuns() {
  const player = cursor.follow(new Player());
  const charts = data.measures.map((measure) => ({aside: measure.aside, ...chart(measure, player)})).filter((c) => c.element);
  const [main, aside] = [charts.filter((c) => !c.aside), charts.filter((c) => c.aside)];
  const worst = worstFrames();
  page.append(make('div', {class: 'watch' + (several ? ' wide' : '')},
    make('div', {class: 'movie'}, player.element, controls(player)),
    make('div', {class: 'curves'}, make('div', {class: 'charts'}, ...main.map((c) => c.element)),
      aside.length ? make('details', {}, make('summary', {}, 'More curves'), make('div', {class: 'charts'}, ...aside.map((c) => c.element))) : null),
    make('div', {class: 'findings'}, ...(worst ? [make('h2', {}, 'Frames worth a look'), worst] : []), make('h2', {}, 'Certificate'), certificate())));
  const seen = runs.filter((run) => run.view);
  if (seen.length) page.append(make('h2', {}, 'The cloth, to be turned'), viewOf(seen, cursor));
  for (const c of charts) c.start();
}

function build() {
  page.append(make('header', {}, make('h1', {}, data.title),
    data.verdict ? make('span', {class: 'badge ' + data.verdict.tone, id: 'verdict'}, data.verdict.text) : null));
  for (const line of data.lines || []) page.append(make('p', {class: 'faint'}, line));
  for (const fault of data.faults || []) page.append(make('p', {class: 'note bad'}, fault));
  if (data.golden && runs.length) page.append(goldenNote(data.golden));
  if (data.picture) page.append(pictureOf(data.picture.url, data.picture.text));
  if (runs.length) showRuns();
  if (data.golden) page.append(...goldens(data.golden));
  if ((data.facts || []).length)
    page.append(make('h2', {}, 'Made from'), table(data.facts_head || null, data.facts.map(([name, texts]) => [name, ...texts])));
  if ((data.notes || []).length) page.append(make('h2', {}, 'Notes'), ...data.notes.map((note) => make('p', {class: 'note'}, note)));
  for (const run of runs)
    if (run.scene) page.append(make('details', {}, make('summary', {}, 'The scene' + (several ? ' of ' + run.label : '') + ', every default written out'), make('pre', {}, run.scene)));
  if (data.text) page.append(make('details', {}, make('summary', {}, 'As text'), make('pre', {}, data.text)));
  window.addEventListener('hashchange', () => cursor.fromAddress());
  cursor.fromAddress();
  window.clothPage = {cursor, data};
}

build();
