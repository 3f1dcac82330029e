// Previews of moves: planned and drawn without a motion, made by Go, gone with everything else.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {after, before, test} from 'node:test';
import {CrclClient, Daemon, openBrowser, openPage, stopAll, until} from './harness.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

let daemon, browser, page;

before(async () => {
  daemon = await Daemon.start();
  browser = await openBrowser();
  page = await openPage(browser, daemon);
  await makeReady('fanuc');
});
after(async () => {
  await browser?.close();
  await stopAll();
});

const robot = (index, of = page) =>
  of.evaluate((i) => {
    const state = document.querySelector('main.stage').view.state.snapshot.robots[i];
    const {x, y, z} = state.toolInReference.positionM;
    return {tool: [x, y, z], ticket: String(state.action.ticket), moving: state.moving};
  }, index);
const drawn = (of = page) =>
  of.evaluate(() => document.querySelector('main.stage').view.ghosts.root.children.length);
const words = (name = 'fanuc', of = page) => of.getByTestId(`${name}-preview-text`).textContent();
const near = (a, b, m) => Math.hypot(...a.map((v, i) => v - b[i])) < m;

async function makeReady(name, of = page) {
  await of.getByTestId(`choose-${name}`).click();
  await of.getByTestId(`init-${name}`).click();
  await until('a ready robot', () => of.getByTestId(`${name}-preview-open`).isEnabled());
}

/** The current pose as the target, moved along the axes of the robot [mm]. */
async function setTarget(offset_mm, name = 'fanuc', of = page) {
  await of.getByTestId(`robot-${name}`).getByRole('button', {name: 'Current pose'}).click();
  for (const [i, axis] of ['x', 'y', 'z'].entries()) {
    const field = of.getByTestId(`${name}-target-${axis}`);
    await field.fill(String(Number(await field.inputValue()) + offset_mm[i]));
  }
}

async function preview(name = 'fanuc', of = page) {
  await of.getByTestId(`${name}-preview-open`).click();
  return until('a plan', async () => {
    const text = await words(name, of);
    return /^This /.test(text) && text;
  });
}

const isClosed = (name = 'fanuc', of = page) =>
  until('no preview', () => of.getByTestId(`${name}-preview`).isHidden());

test('a preview is drawn, moves nothing, and Go makes exactly its move', async () => {
  const start = await robot(0);
  await setTarget([0, 150, 40]);
  assert.match(await preview(), /^This free move takes \d+\.\d\d s for \d+\.\d\d mm\.$/);
  assert.ok((await drawn()) > 5, 'the path and ghosts of the links');
  assert.deepEqual(await robot(0), start);
  await page.getByTestId('fanuc-preview-straight').click();
  await until('a line', async () => /^This straight line takes/.test(await words()));
  assert.match(await words(), / for 155\.\d\d mm\.$/);
  await page.getByTestId('fanuc-preview-go').click();
  await isClosed();
  assert.equal(await drawn(), 0);
  const goal = start.tool.map((v, i) => v + [0, 0.15, 0.04][i]);
  await until('the target', async () => near((await robot(0)).tool, goal, 1e-4));
});

test('a move that would be refused says why and where, and is not made', async () => {
  await setTarget([0, 0, -800]);
  await preview();
  await page.getByTestId('fanuc-preview-close').click();
  await isClosed();
  await setTarget([0, 0, 0]);
  await page.getByTestId('fanuc-target-z').fill('-70'); // in the table
  await page.getByTestId('fanuc-preview-open').click();
  await until('a warning', async () => /Direct moves are not checked: /.test(await words()));
  assert.ok(await page.getByTestId('fanuc-preview-go').isEnabled());
  // The mode is a command to the robot: the preview ends with it.
  await page.getByTestId('planning-fanuc').selectOption({label: 'refuse collisions'});
  await isClosed();
  assert.match(await preview(), /^This free move would be refused: .* (touches|would touch) /);
  assert.ok((await drawn()) > 5);
  const go = page.getByTestId('fanuc-preview-go');
  assert.ok(await go.isDisabled());
  assert.equal(await go.getAttribute('title'), 'The move would be refused.');
  await page.getByTestId('planning-fanuc').selectOption({label: 'direct moves'});
  await isClosed();
});

test('Escape closes the preview and stops nothing', async () => {
  await setTarget([0, -100, 0]);
  await page.getByTestId('fanuc-preview-open').focus();
  await page.keyboard.press('Enter');
  await until('a plan', async () => /^This /.test(await words()));
  const {ticket} = await robot(0);
  await page.keyboard.press('Escape');
  await isClosed();
  assert.equal(await drawn(), 0);
  assert.equal((await robot(0)).ticket, ticket, 'no command');
  // The keyboard alone: open, Tab to Go, press it.
  const before = await robot(0);
  await page.keyboard.press('Enter');
  await until('a plan', async () => /^This /.test(await words()));
  const goHasFocus = () =>
    page.evaluate(() => document.activeElement?.dataset.testid === 'fanuc-preview-go');
  for (let i = 0; i < 5 && !(await goHasFocus()); ++i) await page.keyboard.press('Tab');
  assert.ok(await goHasFocus());
  await page.keyboard.press('Enter');
  await isClosed();
  const goal = before.tool.map((v, i) => v + [0, -0.1, 0][i]);
  await until('the target', async () => near((await robot(0)).tool, goal, 1e-4));
});

test('another robot, another target and commands of others end the preview', async () => {
  await setTarget([0, 100, 0]);
  await preview();
  await page.getByTestId('choose-motoman').click();
  await isClosed();
  assert.equal(await drawn(), 0);
  await page.getByTestId('choose-fanuc').click();
  await preview();
  await page.getByTestId('fanuc-target-x').fill('300');
  await isClosed();
  await setTarget([0, 100, 0]);
  await preview();
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  client.close();
  await isClosed();
});

test('a target out of reach is refused in the chosen units', async () => {
  await page.getByLabel('Unit of lengths').selectOption('in');
  await setTarget([100, 0, 0]);
  assert.match(await preview(), /^This free move would be refused: .*\bin\b/);
  assert.equal(await drawn(), 0, 'there is no way to draw');
  await page.getByLabel('Unit of lengths').selectOption('mm');
  assert.match(await words(), /\bmm\b/);
  await page.keyboard.press('Escape');
  await isClosed();
});

for (const colorScheme of ['dark', 'light'])
  test(`on a phone the preview fits and has no findings, ${colorScheme}`, async () => {
    const phone = await openPage(browser, daemon, {
      viewport: {width: 390, height: 844},
      bypassCSP: true,
      colorScheme
    });
    await phone.getByTestId('choose-fanuc').click();
    await phone.evaluate(axe);
    // A page that was too busy to keep its connection begins again without the preview.
    const found = await until('a preview that stays', async () => {
      await setTarget([0, 60, 20], 'fanuc', phone);
      await preview('fanuc', phone);
      const faults = await phone.evaluate(async () => {
        const box = document.querySelector('.robot:not([hidden]) .preview');
        const {violations} = await globalThis.axe.run(box, {resultTypes: ['violations']});
        const outside = [...box.querySelectorAll('p, button')].filter((part) => {
          const {left, right} = part.getBoundingClientRect();
          return left < 0 || right > innerWidth;
        });
        const wide = document.documentElement.scrollWidth > innerWidth;
        return [
          ...violations.map(({id, nodes}) => `${id}: ${nodes.map(({html}) => html)}`),
          ...outside.map((part) => `outside: ${part.outerHTML}`),
          ...(wide ? ['the page scrolls sideways'] : [])
        ];
      });
      return (await phone.getByTestId('fanuc-preview').isVisible()) && {faults};
    });
    assert.deepEqual(found.faults, []);
    assert.deepEqual(phone.complaints, []);
    await phone.context().close();
  });

test('without WebGL the words are the same', async () => {
  const plain = await openPage(browser, daemon, {webgl: false});
  await plain.getByTestId('choose-fanuc').click();
  await setTarget([0, 60, 20], 'fanuc', plain);
  assert.match(await preview('fanuc', plain), /^This free move takes/);
  await plain.keyboard.press('Escape');
  await isClosed('fanuc', plain);
  assert.deepEqual(plain.complaints, []);
  await plain.context().close();
});

test('nothing was complained of', () => assert.deepEqual(page.complaints, []));
