// The timeline under the view: any moment of the past, in charts, taps and scene on one clock; and the
// cell put back to one.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {CrclClient, Daemon, openPlainBrowser, openPage, stopAll, until} from './harness.mjs';

let daemon, browser, page, client;

before(async () => {
  daemon = await Daemon.start(['--seed', '7']);
  browser = await openPlainBrowser();
  page = await openPage(browser, daemon);
  client = await CrclClient.open(daemon.ports['crcl.fanuc']);
});
after(async () => {
  client?.close();
  await browser?.close();
  await stopAll();
});

const tab = (name) => page.getByRole('tab', {name}).click();
/** Shown state: step, epoch, the robot's first joint, contacts. */
const shown = () =>
  page.evaluate(() => {
    const {state} = document.querySelector('main.stage').view;
    const {snapshot, past} = state;
    return {
      past: past !== null,
      epoch: Number(snapshot.epoch),
      step: Number(snapshot.step),
      joint: snapshot.robots[0].joints[0].positionRad,
      contacts: snapshot.contactCount
    };
  });
const live = () =>
  page.evaluate(() => {
    const {live} = document.querySelector('main.stage').view.state;
    return {epoch: Number(live.epoch), step: Number(live.step)};
  });
const slider = () => page.getByTestId('moment');
const goTo = async (step) => {
  await until(
    'the line to reach it',
    async () => Number(await slider().getAttribute('max')) >= step
  );
  await slider().fill(String(step)); // of the first epoch, which is kept whole
  await until(`step ${step}`, async () => {
    const now = await shown();
    return now.past && now.step === step;
  });
};

const seen = [];

test('what was seen live is there again, bit for bit', async () => {
  await client.run('InitCanonType');
  // So slow that a page that draws once a second sees enough of it.
  const moved = client.moveJoints([30, 0, 0, 0, 0, 0], 3);
  await until('some of the motion', async () => {
    const now = await shown(),
      last = seen.at(-1);
    if (!last || (now.step > last.step + 100 && now.joint !== last.joint)) seen.push(now);
    return seen.length >= 8;
  });
  await moved;
  for (const moment of [...seen].reverse()) {
    await goTo(moment.step);
    assert.deepEqual(await shown(), {...moment, past: true});
    assert.equal(
      await page.getByTestId('past-time').textContent(),
      `${(moment.step / 1000).toFixed(3)} s`
    );
  }
});

test('a millisecond back, a millisecond on, by buttons and keys', async () => {
  const {step} = seen[3];
  await goTo(step);
  const at = (wanted) => until(`step ${wanted}`, async () => (await shown()).step === wanted);
  await page.getByTestId('past-back').click();
  await at(step - 1);
  assert.match(await page.getByTestId('sim-time').textContent(), /^\d+\.\d{3} s$/);
  await page.getByTestId('past-on').click();
  await at(step);
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('[');
  await at(step - 1);
  await page.keyboard.press(']');
  await at(step);
});

test('it plays slowly, and stops', async () => {
  const {step} = seen[1];
  await goTo(step);
  await page.getByTestId('past-speed').selectOption('0.25');
  await page.getByTestId('past-play').click();
  await until('a later moment', async () => (await shown()).step > step + 50);
  await page.getByTestId('past-play').click();
  const {step: stopped} = await until('rest', async () => {
    const first = await shown();
    await new Promise((go) => setTimeout(go, 300));
    return (await shown()).step === first.step && first;
  });
  assert.ok(stopped > step + 50);
});

test('charts and taps show the same moment', async () => {
  await tab('Charts');
  await page.getByTestId('chart-choice').fill('fanuc J1 position');
  await page.getByTestId('chart-choice').press('Enter');
  const reading = page.getByTestId('reading fanuc J1 position');
  const moment = seen[5];
  await goTo(moment.step);
  await until('the value of the moment', async () => {
    const [time, value] = (await reading.textContent()).split(': ');
    return (
      time === `${(moment.step / 1000).toFixed(3)} s` &&
      Math.abs(parseFloat(value) - (moment.joint * 180) / Math.PI) < 1e-3
    );
  });
  await tab('CRCL');
  const rows = page.getByTestId('crcl-rows').locator('tr');
  await goTo(seen[7].step);
  await until('the motion’s command', async () =>
    /ActuateJoints/.test((await rows.allTextContents()).join('\n'))
  );
  await goTo(1);
  await until('no command yet', async () => (await rows.count()) === 0);
});

test('the past takes no commands but a stop', async () => {
  await goTo(seen[2].step);
  await until('a locked button', () => page.getByTestId('reset').isDisabled());
  assert.match(await page.getByTestId('reset').getAttribute('title'), /The past is shown/);
  assert.ok(await page.getByTestId('stop-cell').isEnabled());
  await page.getByTestId('past-now').click();
  await until('the present', async () => !(await shown()).past);
  await until('a free button', () => page.getByTestId('reset').isEnabled());
  assert.equal(await page.getByTestId('past-time').textContent(), 'now');
});

test('bookmarks: one’s own, and those of commands', async () => {
  const {step} = seen[4];
  await goTo(step);
  await page.getByTestId('bookmark').click();
  await page.getByRole('dialog').getByLabel('Text of the bookmark').fill('look here');
  await page.getByTestId('confirm').click();
  await goTo(seen[7].step);
  await until('the mark', () => page.locator('.marks [data-kind=own]').count());
  await page.getByTestId('bookmark-before').click();
  await until('the bookmark', async () => (await shown()).step === step);
  assert.match(await page.getByTestId('bookmark-text').textContent(), /look here/);
  // A command of before: the one that began the motion.
  await page.getByTestId('bookmark-before').click();
  await until('a command', async () => (await shown()).step < step);
  assert.match(await page.getByTestId('bookmark-text').textContent(), /fanuc/);
});

test('the cell goes back to a moment, when it is asked twice', async () => {
  const moment = seen[4];
  await goTo(moment.step);
  const before = await live();
  await page.getByTestId('resume-here').click();
  await page.getByRole('dialog').getByRole('button', {name: 'Cancel'}).click();
  assert.equal((await live()).epoch, before.epoch);
  await page.getByTestId('resume-here').click();
  const dialog = page.getByRole('dialog', {name: 'Resume from here?'});
  assert.match(await dialog.textContent(), /returns to \d+\.\d{3} s/);
  await dialog.getByTestId('confirm').click();
  await until('a new epoch', async () => (await live()).epoch === before.epoch + 1);
  const now = await live();
  assert.ok(now.step >= moment.step && now.step < before.step, JSON.stringify({now, moment}));
  await until('the present', async () => !(await shown()).past);
  // The motion that was under way goes on to its end, and what was before can still be seen.
  await until(
    'the end of the motion',
    async () => Math.abs((await shown()).joint - (30 * Math.PI) / 180) < 1e-6
  );
  await goTo(seen[6].step);
  assert.deepEqual(await shown(), {...seen[6], past: true});
  await page.getByTestId('past-now').click();
  assert.deepEqual(page.complaints, []);
});
