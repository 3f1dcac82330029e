// The scenario editor: a scenario from nothing, with mistakes, undo, a saved file, and a run.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {bin, Daemon, openPage, openPlainBrowser, stopAll, until} from './harness.mjs';
import {layoutFaults, unreachable} from './layout.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const shipped = (name) => readFileSync(join(bin, `../../../world/scenarios/${name}.yaml`), 'utf8');

let daemon, browser, page, folder;

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'aprsim-scenario-'));
  daemon = await Daemon.start();
  browser = await openPlainBrowser();
  page = await openPage(browser, daemon, {viewport: {width: 1440, height: 900}, bypassCSP: true});
  await page.evaluate(axe);
  await page.getByRole('tab', {name: 'Scenarios', exact: true}).click();
});
after(async () => {
  await browser?.close();
  await stopAll();
  rmSync(folder, {recursive: true, force: true});
});

const id = (name) => page.getByTestId(name);
const section = () => page.getByRole('region', {name: 'Scenario editor'});
/** Waits until the daemon has checked the present text. */
const idle = () =>
  until(
    'the editor to be idle',
    async () => (await section().getAttribute('aria-busy')) === 'false'
  );
const text = () => id('scenario-text').inputValue();
const summary = async () => {
  await idle();
  return id('scenario-summary').textContent();
};
const problems = async () => {
  await idle();
  return id('scenario-problems').locator('li').allTextContents();
};
const complaint = () => id('scenario-complaint').textContent();
const value = (name) => id(`scenario-${name}`).inputValue();

async function click(name) {
  await idle();
  await id(name).click();
  await idle();
}
async function add(label) {
  await id('scenario-offer').selectOption({label});
  await click('scenario-add');
}
async function set(name, typed) {
  await id(`scenario-${name}`).fill(typed);
  await id(`scenario-${name}`).press('Enter');
  await idle();
}
async function type(whole) {
  await id('scenario-text').fill(whole);
  await id('scenario-text').blur();
  await until('the text', async () => (await id('scenario-text').inputValue()) === whole);
  await idle();
}

test('a shipped scenario opens with its own bytes', async () => {
  await until('the scenarios', async () => (await id('scenario').locator('option').count()) > 5);
  await id('scenario').selectOption('urgent_with_slow_robot');
  await id('edit-scenario').click();
  await until('the text', async () => (await text()) === shipped('urgent_with_slow_robot'));
  assert.match(await summary(), /^Valid: 3 kits, 2 faults, at most 500 s; as its file\. $/);
  assert.match(await id('event-orders-2').textContent(), /when fault:slow/);
  assert.match(
    await id('event-faults-0').getAttribute('aria-label'),
    /robot-slow fanuc, at 12 s, for 20 s/
  );
  assert.ok(await id('scenario-run').isEnabled());
});

test('one that changes the parts can be edited, but not run in the cell', async () => {
  await id('scenario-shipped').selectOption('belt_supply');
  await click('scenario-open');
  assert.equal(await text(), shipped('belt_supply'));
  assert.match(await summary(), /Valid: 1 kit.*keeps its own parts/);
  assert.ok(await id('scenario-run').isDisabled());
  assert.match(await id('scenario-run').getAttribute('title'), /aprsim scenario run FILE/);
  await click('scenario-undo');
  assert.equal(await text(), shipped('urgent_with_slow_robot'));
});

test('a scenario from nothing: an order and two faults', async () => {
  await click('scenario-new');
  assert.match(
    await text(),
    /^# Times in simulated seconds.*\n\ndescription: A new scenario\nscene: aprs\n/
  );
  assert.match(await summary(), /Valid: 0 kits/);
  await set('description', 'Two troubles, and a kit');
  await set('stop-time_limit_s', '20');
  await add('order sku_kit_m2l1_vessel');
  assert.match(await text(), /orders:\n {2}- \{name: kit_1, tray: sku_kit_m2l1_vessel\}/);
  await add('robot slow');
  assert.equal(await value('target-0'), 'fanuc');
  await id('scenario-target-0').selectOption('motoman');
  await idle();
  await set('at_s', '2');
  await set('for_s', '4');
  await set('with-share', '0.5');
  await add('part missing');
  await id('scenario-target-0').selectOption('part_medium_gear_1');
  await idle();
  await set('at_s', '3');
  assert.match(
    await text(),
    /faults:\n {2}- \{kind: robot-slow, target: motoman, at_s: 2, for_s: 4, with: \{share: 0.5\}\}\n {2}- \{kind: part-missing, target: part_medium_gear_1, at_s: 3\}\n/
  );
  assert.match(await summary(), /^Valid: 1 kit, 2 faults, at most 20 s; not saved/);
  assert.equal(await id('scenario-for_s').count(), 0, 'a momentary fault has no duration');
});

test('mistakes are told by the daemon, with line and key', async () => {
  const before = await text();
  await id('event-faults-0').click();
  const field = id('scenario-with-share');
  assert.equal(await field.getAttribute('placeholder'), '0.3');
  assert.match(await field.getAttribute('title'), /: 0 to 1$/);
  await set('with-share', '7');
  const line = before.split('\n').findIndex((one) => one.includes('robot-slow')) + 1;
  const [told, ...more] = await problems();
  assert.equal(more.length, 0);
  assert.match(told, new RegExp(`^line ${line}, column \\d+: faults\\[0\\]\\.with.*7`));
  assert.match(await summary(), /One mistake/);
  assert.ok(await id('scenario-run').isDisabled());
  await id('scenario-problems').getByRole('button').click();
  const chosen = await id('scenario-text').evaluate((area) =>
    area.value.slice(area.selectionStart, area.selectionEnd)
  );
  assert.match(chosen, /kind: robot-slow.*share: 7/);
  await click('scenario-undo');
  assert.equal(await text(), before);
  await set('with-share', 'a bit');
  assert.match(await complaint(), /share: “a bit” is not a number/);
  await type(`${before}\nfault: []\norders: 3\n`);
  assert.ok((await problems()).length > 0);
  await type(`${before}\nfault: []\n`);
  assert.match((await problems())[0], /line \d+, column 1: fault/);
  await type(before);
  assert.deepEqual(await problems(), []);
});

test('events are dragged, stretched, and moved by keys; undo gives the same bytes', async () => {
  const before = await text();
  const drag = async (name, by_px) => {
    const box = await id(name).boundingBox();
    const [x, y] = [box.x + Math.min(6, box.width / 2), box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + by_px / 2, y);
    await page.mouse.move(x + by_px, y, {steps: 3});
    await page.mouse.up();
    await idle();
  };
  const track = await page.locator('.timeline .axis').boundingBox();
  const second_px = track.width / 30;
  await drag('event-faults-0', 5 * second_px);
  const begin = Number(await value('at_s'));
  assert.ok(Math.abs(begin - 7) < 0.3, `${begin}`);
  assert.ok(Math.abs(begin * 10 - Math.round(begin * 10)) < 1e-9, `${begin} is on the grid`);
  await drag('stretch-faults-0', 3 * second_px);
  const lasts = Number(await value('for_s'));
  assert.ok(Math.abs(lasts - 7) < 0.3, `${lasts}`);
  await id('event-faults-0').focus();
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('Shift+ArrowLeft');
  await page.keyboard.press('ArrowDown');
  await idle();
  assert.equal(Number(await value('at_s')), Number((begin + 0.4).toFixed(3)));
  assert.equal(Number(await value('for_s')), Number((lasts - 0.5).toFixed(3)));
  for (let i = 0; i < 5; ++i) await page.keyboard.press('Control+z');
  await idle();
  assert.equal(await text(), before);
  await page.keyboard.press('Control+y');
  await idle();
  assert.equal(Number(await value('at_s')), begin);
  await click('scenario-undo');
});

test('copies, removals and Escape', async () => {
  const before = await text();
  await id('event-orders-0').click();
  await click('scenario-copy');
  assert.match(await text(), /\{name: kit_2, tray: sku_kit_m2l1_vessel, at_s: 5\}/);
  assert.match(await summary(), /Valid: 2 kits/);
  await id('event-orders-1').focus();
  await page.keyboard.press('Delete');
  await idle();
  assert.equal(await text(), before);
  await id('event-faults-1').click();
  await page.keyboard.press('Escape');
  assert.equal(await section().locator('[aria-pressed=true]').count(), 0);
  assert.ok(await section().isVisible());
  await page.keyboard.press('Escape');
  assert.ok(await section().isHidden());
  await id('scenario-editor').click();
  await until('the draft', async () => (await text()) === before);
});

test('the saved file passes the check of scenarios, and is opened again', async () => {
  await id('scenario-file-name').fill('two troubles');
  await id('scenario-file-name').press('Enter');
  assert.equal(await value('file-name'), 'two_troubles');
  await idle();
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    id('scenario-save').click()
  ]);
  assert.equal(download.suggestedFilename(), 'two_troubles.yaml');
  const file = join(folder, download.suggestedFilename());
  await download.saveAs(file);
  assert.equal(readFileSync(file, 'utf8'), await text());
  assert.match(
    execFileSync(join(bin, 'aprsim'), ['scenario', 'check', file], {encoding: 'utf8'}),
    /two_troubles is valid: 1 kits, 2 faults/
  );
  assert.match(await summary(), /as its file/);
  const own = join(folder, 'own.yaml');
  writeFileSync(own, shipped('pick'));
  await id('scenario-file').setInputFiles(own);
  await until('the text', async () => (await text()) === shipped('pick'));
  assert.equal(await value('file-name'), 'own');
  await click('scenario-undo');
  assert.equal(await text(), readFileSync(file, 'utf8'));
});

test('nothing is cut off or unreadable, on screens and phones, dark and light', async () => {
  await id('event-faults-0').click();
  for (const [width, height, scheme] of [
    [1440, 900, 'dark'],
    [1280, 800, 'light'],
    [390, 844, 'dark'],
    [390, 844, 'light']
  ]) {
    await page.setViewportSize({width, height});
    await page.emulateMedia({colorScheme: scheme});
    await page.waitForTimeout(300);
    if (process.env.EDITOR_PICTURES)
      await page.screenshot({
        path: join(process.env.EDITOR_PICTURES, `scenario-${width}-${scheme}.png`)
      });
    const at = `${width}, ${scheme}`;
    assert.deepEqual(await layoutFaults(page), [], at);
    assert.deepEqual(await unreachable(page, '.scenario-editor'), [], at);
    const {violations} = await page.evaluate(() =>
      globalThis.axe.run(document.querySelector('.scenario-editor'), {
        resultTypes: ['violations'],
        rules: {'target-size': {enabled: true}}
      })
    );
    assert.deepEqual(
      violations.map((v) => `${v.id}: ${v.nodes[0].html}`),
      [],
      at
    );
  }
  await page.setViewportSize({width: 1440, height: 900});
});

test('it runs in the cell, and its faults are in the log', async () => {
  await id('scenario-file-name').fill('two_troubles');
  await id('scenario-file-name').press('Enter');
  await id('scenario-seed').fill('2');
  await id('scenario-run').click();
  await until('its faults', async () => {
    const rows = await page.locator('.fault-line li').allTextContents();
    return (
      rows.some((row) => /robot-slow motoman/.test(row)) &&
      rows.some((row) => /part-missing part_medium_gear_1/.test(row))
    );
  });
  assert.match(await id('program-state').textContent(), /two_troubles/);
  assert.ok(await id('scenario-run').isDisabled());
  await until('its end', async () =>
    /two_troubles: done/.test(await id('program-state').textContent())
  );
  const lines = await id('program-lines').textContent();
  assert.match(lines, /robot-slow/);
  assert.match(lines, /part-missing/);
  assert.match(await id('orders').textContent(), /kit_1/);
  assert.match(await id('program-report').textContent(), /seed 2\b/);
  assert.deepEqual(page.complaints, []);
});
