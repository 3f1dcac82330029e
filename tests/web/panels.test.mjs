// Every panel at every width, in both colours, with and without WebGL: nothing is cut off, covered or
// unreadable. PANELS=all checks all combinations instead of a covering set; PANELS_PICTURES=DIRECTORY
// saves a picture of each state.
import assert from 'node:assert/strict';
import {mkdirSync, readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {
  CrclClient,
  Daemon,
  openBrowser,
  openPage,
  stopAll,
  until,
  writeRegister
} from './harness.mjs';
import {layoutFaults, unreachable} from './layout.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const kPanels = [
  'Robots',
  'Conveyor',
  'CRCL',
  'Modbus',
  'Charts',
  'Faults',
  'Scenarios',
  'Cameras',
  'Scene'
];
const kSizes = [
  [1280, 800],
  [1440, 900],
  [1920, 1080],
  [390, 844]
];
const kScenario = 'robot_protective_stop';
const all = process.env.PANELS === 'all';
const pictures = process.env.PANELS_PICTURES;

// Each size and each colour with and without WebGL, each size in both colours; fewer where a test
// says so.
const combinations = [false, true].flatMap((webgl) =>
  kSizes.flatMap(([width, height], i) =>
    ['dark', 'light']
      .filter((_, c) => all || (i + c + Number(webgl)) % 2 === 0)
      .map((colorScheme) => ({webgl, width, height, colorScheme}))
  )
);

let browser, daemon;
let shown = null; // one page at a time, since one that draws takes much of a processor

before(async () => {
  browser = await openBrowser();
  daemon = await Daemon.start();
});
after(async () => {
  await browser?.close();
  await stopAll();
});

async function open(of, options = {}) {
  const page = await openPage(browser, of, {webgl: false, bypassCSP: true, ...options});
  await page.evaluate(axe);
  return page;
}

/** The page of a combination, as that asks for it. */
async function arrange({webgl, width, height, colorScheme}) {
  if (shown?.webgl !== webgl) {
    await shown?.page.context().close();
    shown = {webgl, page: await open(daemon, {webgl})};
  }
  const {page} = shown;
  await page.setViewportSize({width, height});
  await page.emulateMedia({colorScheme});
  await until(`${colorScheme} colours`, () =>
    page.evaluate((wanted) => document.documentElement.dataset.theme === wanted, colorScheme)
  );
  return page;
}

const labelOf = ({webgl, width, height, colorScheme}) =>
  `${width}x${height} ${colorScheme}${webgl ? '' : ' without WebGL'}`;

/** Waits until the page has drawn what it was told last, and transitions have ended. */
const settle = (page) =>
  page.evaluate(async () => {
    const frame = () => new Promise((go) => requestAnimationFrame(go));
    await frame();
    await frame();
    const ending = document
      .getAnimations()
      .filter((one) => Number.isFinite(one.effect.getComputedTiming().endTime));
    await Promise.allSettled(ending.map((one) => one.finished));
  });

/** Faults of what a page shows. axe looks at the part `read`. */
async function faultsOf(page, label, {reads = true, within = 'body', read = 'body'} = {}) {
  await settle(page);
  if (pictures) {
    mkdirSync(pictures, {recursive: true});
    await page.screenshot({path: join(pictures, `${label.replaceAll(' ', '-')}.png`)});
  }
  const faults = [
    ...(await layoutFaults(page)),
    ...(await unreachable(page, within)),
    ...(reads ? await findings(page, read) : [])
  ];
  return faults.map((fault) => `${label}: ${fault}`);
}

/** Findings of axe: contrast, labels, sizes of targets. */
async function findings(page, part) {
  const {violations} = await page.evaluate(
    (chosen) =>
      globalThis.axe.run(chosen === 'body' ? document : chosen, {
        resultTypes: ['violations'],
        rules: {'target-size': {enabled: true}}
      }),
    part
  );
  return violations.map(({id, nodes}) => `${id}: ${nodes.map(({html}) => html).slice(0, 3)}`);
}

async function openPanel(page, name) {
  await page.getByRole('tab', {name}).click();
  await page.mouse.move(2, 2);
}

test('until something has run, the way to begin is in view', async () => {
  const faults = [];
  for (const combination of combinations) {
    const page = await arrange(combination);
    const label = `start ${labelOf(combination)}`;
    faults.push(...(await faultsOf(page, label, {reads: false, within: '.stage, .tabrow'})));
    if (!(await page.getByTestId('start-demo').isVisible())) faults.push(`${label}: no demo`);
    assert.equal(await page.getByTestId('no-webgl').count(), combination.webgl ? 0 : 1, label);
  }
  assert.deepEqual(faults, []);
});

/** Starts the scenario, again where it has ended. */
async function keepScenarioRunning(page) {
  const state = page.getByTestId('program-state');
  const isRunning = async () => / running: /.test(await state.textContent());
  if (await isRunning()) return;
  await openPanel(page, 'Scenarios');
  await page.getByTestId('scenario').selectOption(kScenario);
  await page.getByTestId('run-scenario').click();
  await until('the scenario to run', isRunning);
}

test('each panel is whole and readable while a scenario runs', async () => {
  const faults = [];
  // Drawing takes most of the time, and the panels beside it are the same.
  const chosen = combinations.filter(({webgl, width}) => all || !webgl || width === 1440);
  for (const combination of chosen) {
    const page = await arrange(combination);
    await keepScenarioRunning(page);
    // Panels do not depend on the view beside them.
    for (const name of all || !combination.webgl ? kPanels : ['Robots', 'Charts']) {
      await openPanel(page, name);
      if (name === 'CRCL')
        await until('commands', () => page.getByTestId('crcl-rows').locator('tr').count());
      const label = `${name} ${labelOf(combination)}`;
      // Once in each colour: what axe looks at hardly depends on the width.
      const reads = all || (!combination.webgl && [1280, 390].includes(combination.width));
      // The page around the panels is the same beside each.
      const read = all || name === kPanels[0] ? 'body' : `#panel-${name}`;
      faults.push(...(await faultsOf(page, label, {reads, read, within: `#panel-${name}`})));
    }
    if (await page.getByTestId('start').isVisible())
      faults.push(`${labelOf(combination)}: the start is still in view`);
    faults.push(...page.complaints);
  }
  assert.deepEqual(faults, []);
});

/** Pixels by which the pendant of the chosen robot is higher than its panel. */
const tooHigh = (page) =>
  page
    .locator('.panel.robots')
    .evaluate(({scrollHeight, clientHeight}) => scrollHeight - clientHeight);

test('while the demo runs, the pendant of a robot with a gear fits 1440 x 900', async () => {
  const page = await arrange({webgl: false, width: 1440, height: 900, colorScheme: 'light'});
  await openPanel(page, 'Scenarios');
  if (await page.getByTestId('stop-program').isEnabled())
    await page.getByTestId('stop-program').click();
  await until('the end of the scenario', () => page.getByTestId('run-demo').isEnabled());
  await page.getByTestId('run-demo').click();
  await openPanel(page, 'Robots');
  for (const name of ['fanuc', 'motoman']) {
    await page.getByTestId(`choose-${name}`).click();
    const robot = page.getByTestId(`robot-${name}`);
    await until(`a gear at ${name}`, async () =>
      /holdspart_/.test(await robot.locator('.facts').last().textContent())
    );
    assert.deepEqual(await faultsOf(page, `demo ${name}`), []);
    assert.ok((await tooHigh(page)) <= 0, `${name} needs ${await tooHigh(page)} px more`);
  }
});

test('arms with slides and seven joints fit, in any units', async () => {
  const arms = await Daemon.start(['--scene', 'arms']);
  const page = await open(arms, {colorScheme: 'light'});
  const faults = [];
  for (const [length, angle] of [
    ['mm', 'deg'],
    ['in', 'rad']
  ]) {
    await page.getByLabel('Unit of lengths').selectOption(length);
    await page.getByLabel('Unit of angles').selectOption(angle);
    for (const name of ['panda', 'scara']) {
      await page.getByTestId(`choose-${name}`).click();
      for (const [width, height] of kSizes) {
        await page.setViewportSize({width, height});
        const label = `${name} ${width}x${height} ${length} ${angle}`;
        const reads = width === 390;
        faults.push(...(await faultsOf(page, label, {reads, within: '#panel-Robots'})));
        if (width === 1440 && (await tooHigh(page)) > 0)
          faults.push(`${label}: ${await tooHigh(page)} px too high`);
      }
    }
  }
  // Panels say that this scene has neither.
  for (const [panel, lack] of [
    ['Conveyor', /has no conveyor/],
    ['Cameras', /has no cameras/]
  ]) {
    await openPanel(page, panel);
    assert.match(await page.locator(`#panel-${panel}`).textContent(), lack);
    faults.push(...(await faultsOf(page, `arms ${panel}`)));
  }
  assert.deepEqual(faults, []);
  await page.context().close();
  await arms.stop();
});

/** Shows something on a page of both sizes and collects the faults. */
async function check(page, label, faults) {
  for (const [width, height] of [kSizes[0], kSizes[3]]) {
    await page.setViewportSize({width, height});
    const options = {reads: width === 390, within: '.none'};
    faults.push(...(await faultsOf(page, `${label} ${width}x${height}`, options)));
  }
}

test('errors, details, faults, the past, dialogs and a lost daemon are whole and readable', async () => {
  const other = await Daemon.start();
  const page = await open(other);
  const faults = [];
  const client = await CrclClient.open(other.ports['crcl.motoman']);
  await client.run('InitCanonType');
  await assert.rejects(client.moveJoints([500, 0, 0, 0, 0, 0, 0]));
  client.close();
  await page.getByTestId('choose-motoman').click();
  await check(page, 'error', faults);
  await writeRegister(other.ports.modbus, 0x8002, 15000);
  for (const wire of ['CRCL', 'Modbus']) {
    await openPanel(page, wire);
    await page.getByTestId(`${wire.toLowerCase()}-rows`).getByRole('button').first().click();
    await check(page, `${wire} detail`, faults);
  }
  await openPanel(page, 'Scenarios');
  await page.getByTestId('inject').click();
  await page.getByTestId('fault-kind').selectOption('joint-weak');
  await page.getByTestId('trigger').selectOption('crossing');
  await page.getByTestId('inject').click();
  await until('a complaint', async () =>
    /limit is empty/.test(await page.getByTestId('fault-complaint').textContent())
  );
  await page.getByTestId('trigger').selectOption('at');
  await page.getByTestId('trigger-time').fill('5000');
  await page.getByTestId('inject').click();
  await until(
    'two faults',
    async () => (await page.getByTestId('injected-count').textContent()) === '2'
  );
  await check(page, 'injected', faults);
  await openPanel(page, 'Faults');
  await page.getByTestId('past-back').click();
  await page.getByTestId('bookmark-before').click();
  await until('the past', async () => (await page.getByTestId('rtf').textContent()) === 'past');
  await check(page, 'past', faults);
  await page.getByTestId('past-now').click();
  for (const opener of ['states', 'clients', 'reset', 'bookmark', 'help-button']) {
    await page.getByTestId(opener).click();
    await page.getByRole('dialog').waitFor();
    await check(page, opener, faults);
    await page.keyboard.press('Escape');
    await page.getByRole('dialog').waitFor({state: 'detached'});
  }
  await other.stop();
  await page.getByTestId('offline').waitFor();
  await check(page, 'offline', faults);
  assert.deepEqual(faults, []);
  await page.context().close();
});
