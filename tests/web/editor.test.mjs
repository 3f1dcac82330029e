// The scene editor: a cell built from an empty scene, with refusals, undo, a saved file, and a reset.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {bin, Daemon, openBrowser, openPage, stopAll, until} from './harness.mjs';
import {layoutFaults, unreachable} from './layout.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

let daemon, browser, page, folder;

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'aprsim-editor-'));
  daemon = await Daemon.start(['--scene', 'empty_belt']);
  browser = await openBrowser();
  page = await openPage(browser, daemon, {
    viewport: {width: 1440, height: 900},
    bypassCSP: true
  });
  await page.evaluate(axe);
  await page.getByRole('tab', {name: 'Scene', exact: true}).click();
});
after(async () => {
  await browser?.close();
  await stopAll();
  rmSync(folder, {recursive: true, force: true});
});

const id = (name) => page.getByTestId(name);
/** Waits until the daemon has answered the last change. */
const idle = () =>
  until('the editor to be idle', () =>
    page.evaluate(() => document.getElementById('panel-Scene').ariaBusy === 'false')
  );
const text = () => id('editor-text').inputValue();
const problem = async () => {
  await idle();
  return id('editor-problem').textContent();
};
const chosen = () =>
  page.evaluate(
    () => document.querySelector('[data-testid=editor-things] [aria-pressed=true]')?.textContent
  );

async function click(name) {
  await idle();
  await id(name).click();
  await idle();
}
async function add(label) {
  await idle();
  await id('editor-offer').selectOption({label});
  await click('editor-add');
  assert.equal(await problem(), '', label);
}
async function setProperty(name, value) {
  await idle();
  await id(`property-${name}`).fill(String(value));
  await id(`property-${name}`).press('Enter');
  await idle();
}
const property = (name) => id(`property-${name}`).inputValue();

/** Place of a body on the screen, and of the point that is this far from it in the world [m]. */
const screenOf = (name, [dx, dy] = [0, 0]) =>
  page.evaluate(
    ([wanted, x, y]) => {
      const {view} = document.querySelector('main.stage');
      const index = view.state.cell.bodies.findIndex((body) => body.name === wanted);
      const mesh = view.parts.meshes[index];
      mesh.updateWorldMatrix(true, false);
      mesh.geometry.computeBoundingBox();
      const at = mesh.position.clone();
      at.x += x;
      at.y += y;
      at.z += mesh.geometry.boundingBox.max.z;
      at.project(view.camera);
      const area = view.renderer.domElement.getBoundingClientRect();
      return [area.left + ((at.x + 1) / 2) * area.width, area.top + ((1 - at.y) / 2) * area.height];
    },
    [name, dx, dy]
  );

test('the draft begins with the text of the scene, comments included, and pauses the cell', async () => {
  assert.match(await id('editor-begin').textContent(), /Pause and edit|Edit/);
  await click('editor-begin');
  const original = readFileSync(join(bin, '../../../world/scenes/empty_belt.yaml'), 'utf8');
  await until('the text', async () => (await text()) === original);
  await until('a paused cell', () =>
    page.evaluate(() => document.querySelector('main.stage').view.state.live?.paused)
  );
  await page.getByTestId('thing-trays/small_gear_vessel_1').click();
  assert.equal(await property('xy_m-0'), '-1.2');
});

test('a change changes one number; undo gives the text back byte for byte', async () => {
  const before = await text();
  await setProperty('xy_m-0', -0.8);
  assert.equal(await text(), before.replace('xy_m: [-1.2, 0]', 'xy_m: [-0.8, 0]'));
  await click('editor-undo');
  assert.equal(await text(), before);
  await click('editor-redo');
  assert.match(await text(), /xy_m: \[-0.8, 0\]/);
  await setProperty('xy_m-0', 'far');
  assert.match(await problem(), /not a number/);
  await setProperty('xy_m-0', -0.8);
});

test('Apply resets the cell to the draft, and the draft stays', async () => {
  await click('editor-apply');
  assert.equal(await problem(), '');
  await click('editor-leave');
  await until('the tray at its new place', () =>
    page.evaluate(() => {
      const {state} = document.querySelector('main.stage').view;
      return Math.abs(state.snapshot.bodies[0].bodyInWorld.positionM.x + 0.8) < 0.01;
    })
  );
  await click('editor-begin');
  assert.match(await text(), /^# A belt with one empty tray[^]*xy_m: \[-0.8, 0\]/);
});

test('a cell from nothing: table, tray, gear and robot', async () => {
  await page.getByText('Text and files').click();
  await click('editor-empty');
  await add('Fixed boxes');
  assert.equal(await chosen(), 'box_1');
  await add('sku_small_gear_vessel');
  assert.equal(await chosen(), 'small_gear_vessel_1');
  assert.match(await text(), /on: box_1/);
  await add('sku_part_small_gear');
  assert.match(await text(), /gears: \{slot_1: part_small_gear_1\}/);
  await id('thing-fixed/box_1').click();
  await add('fanuc_lrmate200id');
  await setProperty('base-xyz_m-0', -0.7);
  await setProperty('base-xyz_m-2', 0);
  assert.equal(await problem(), '');
  await until('the arm in the view', () =>
    page.evaluate(() => {
      const {view} = document.querySelector('main.stage');
      return view.robots.length === 1 && view.robots[0].arm !== null;
    })
  );
});

test('a tray says how many of its slots the robot reaches', async () => {
  const robot = id('thing-robots/fanuc_lrmate200id_1');
  const reach = async () => {
    await id('thing-trays/small_gear_vessel_1').click();
    return id('editor-reach').textContent();
  };
  assert.equal(await reach(), 'Slots in reach from above: fanuc_lrmate200id_1 2 of 4.');
  await robot.click();
  await setProperty('base-xyz_m-0', -3);
  assert.equal(await reach(), 'Slots in reach from above: fanuc_lrmate200id_1 0 of 4.');
  await click('editor-undo');
  assert.match(await reach(), / 2 of 4\.$/);
});

test('keys move, turn and remove; a copy has names of its own', async () => {
  await id('thing-trays/small_gear_vessel_1').click();
  const x = Number(await property('xy_m-0'));
  await page.keyboard.press('ArrowRight');
  await idle();
  await page.keyboard.press('Shift+ArrowUp');
  await idle();
  await page.keyboard.press('r');
  await idle();
  assert.equal(Number(await property('xy_m-0')), Number((x + 0.005).toFixed(6)));
  assert.equal(Number(await property('xy_m-1')), 0.001);
  assert.equal(await property('yaw_deg'), '15');
  for (let i = 0; i < 3; ++i) await click('editor-undo');
  await click('editor-copy');
  assert.equal(await problem(), '');
  assert.equal(await chosen(), 'small_gear_vessel_2');
  assert.match(await text(), /part_small_gear_2/);
});

test('an overlap is refused with both names, and changes nothing', async () => {
  const before = await text();
  const at = [0, 1].map((i) => `xy_m-${i}`);
  await id('thing-trays/small_gear_vessel_1').click();
  const [x, y] = await Promise.all(at.map(property));
  await id('thing-trays/small_gear_vessel_2').click();
  await setProperty(at[0], Number(x) + 0.05);
  if ((await problem()) === '') await setProperty(at[1], Number(y) + 0.02);
  assert.match(await problem(), /small_gear_vessel_[12].* mm deep in small_gear_vessel_[12]/);
  await until('the thing to be marked', () =>
    id('thing-trays/small_gear_vessel_2').evaluate((button) => button.dataset.state === 'bad')
  );
  for (let i = 0; (await text()) !== before && i < 3; ++i) await click('editor-undo');
  assert.equal(await text(), before);
});

test('the clearance to the nearest thing at the same height is shown', async () => {
  await id('thing-trays/small_gear_vessel_2').click();
  const at = ['xy_m-0', 'xy_m-1'];
  const here = (await Promise.all(at.map(property))).map(Number);
  await id('thing-trays/small_gear_vessel_1').click();
  const there = (await Promise.all(at.map(property))).map(Number);
  await id('thing-trays/small_gear_vessel_2').click();
  const size = await page.evaluate(() => {
    const {bodies} = document.querySelector('main.stage').view.state.cell;
    const {value} = bodies.find(({name}) => name === 'small_gear_vessel_2').geometry;
    return [value.boxMaxM.x - value.boxMinM.x, value.boxMaxM.y - value.boxMinM.y];
  });
  const shown = async () => {
    const text = await id('editor-clearance').textContent();
    const [, gap, name] = /^Clearance: ([\d.]+) mm to (.+)\.$/.exec(text) ?? assert.fail(text);
    assert.equal(name, 'small_gear_vessel_1');
    return Number(gap);
  };
  const expected = (x) =>
    1e3 *
    Math.hypot(
      Math.max(0, Math.abs(x - there[0]) - size[0]),
      Math.max(0, Math.abs(here[1] - there[1]) - size[1])
    );
  assert.ok(Math.abs((await shown()) - expected(here[0])) < 0.2, `${await shown()}`);
  const away = here[0] + (here[0] < there[0] ? -0.02 : 0.02);
  await setProperty('xy_m-0', away);
  assert.equal(await problem(), '');
  assert.ok(Math.abs((await shown()) - expected(away)) < 0.2, `${await shown()}`);
  await click('editor-undo');
});

test('the chosen thing is dragged in the view, on a grid of 5 mm', async () => {
  await id('thing-trays/small_gear_vessel_2').click();
  const before = await text();
  const [x, y] = [Number(await property('xy_m-0')), Number(await property('xy_m-1'))];
  const away = [x > 0 ? 0.043 : -0.043, 0];
  const from = await screenOf('small_gear_vessel_2'),
    to = await screenOf('small_gear_vessel_2', away);
  const clearance = () => id('editor-clearance').textContent();
  const atFirst = await clearance();
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move(...to, {steps: 4});
  await until('another clearance while it is dragged', async () => (await clearance()) !== atFirst);
  await page.mouse.up();
  await until('the new text', async () => {
    await idle();
    return (await text()) !== before;
  });
  const now = [Number(await property('xy_m-0')), Number(await property('xy_m-1'))];
  assert.ok(Math.hypot(now[0] - x - away[0], now[1] - y) < 0.012, `${now}`);
  for (const n of now) assert.ok(Math.abs(n / 0.005 - Math.round(n / 0.005)) < 1e-6, `${now}`);
  await click('editor-undo');
  assert.equal(await text(), before);
  await click('editor-redo');
});

test('the saved file passes the check of scenes', async () => {
  await idle();
  const [download] = await Promise.all([page.waitForEvent('download'), id('editor-save').click()]);
  assert.match(download.suggestedFilename(), /\.yaml$/);
  const file = join(folder, download.suggestedFilename());
  await download.saveAs(file);
  assert.equal(readFileSync(file, 'utf8'), await text());
  execFileSync(join(bin, 'aprsim'), ['scene', 'check', file]);
});

test('a cell with other robots is applied', async () => {
  await click('editor-apply');
  assert.equal(await problem(), '');
  assert.doesNotMatch(await id('editor-summary').textContent(), /not applied/);
});

test('a wrong text is refused with its line and is kept for correction', async () => {
  const before = await text();
  await id('editor-text').fill(`${before}\nconveyors: {}\n`);
  await click('editor-use-text');
  assert.match(await problem(), /scene text:\d+:\d+: conveyors/);
  assert.match(await text(), /conveyors/);
  await id('editor-text').fill(before);
  await click('editor-use-text');
  assert.equal(await problem(), '');
});

test('removed things are gone; the file stays valid', async () => {
  await id('thing-trays/small_gear_vessel_2').click();
  await page.keyboard.press('Delete');
  await idle();
  assert.doesNotMatch(await text(), /small_gear_vessel_2/);
  assert.equal(await problem(), '');
});

test('nothing is cut off or unreadable, on screens and phones', async () => {
  await id('thing-robots/fanuc_lrmate200id_1').click();
  // The page's messages pass by themselves.
  await page.locator('.toast').first().waitFor({state: 'detached'});
  for (const [width, height] of [
    [1440, 900],
    [390, 844]
  ]) {
    await page.setViewportSize({width, height});
    await page.waitForTimeout(300);
    if (process.env.EDITOR_PICTURES)
      await page.screenshot({path: join(process.env.EDITOR_PICTURES, `editor-${width}.png`)});
    assert.deepEqual(await layoutFaults(page), [], `${width}`);
    assert.deepEqual(await unreachable(page, '#panel-Scene'), [], `${width}`);
    const {violations} = await page.evaluate(() =>
      globalThis.axe.run(document.getElementById('panel-Scene'), {
        resultTypes: ['violations'],
        rules: {'target-size': {enabled: true}}
      })
    );
    assert.deepEqual(
      violations.map((v) => `${v.id}: ${v.nodes[0].html}`),
      [],
      `${width}`
    );
  }
  assert.deepEqual(page.complaints, []);
});
