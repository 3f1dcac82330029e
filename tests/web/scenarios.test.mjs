// Injected faults, the demo and scenarios on the page.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {Daemon, openPlainBrowser, openPage, stopAll, until} from './harness.mjs';

let daemon, browser, page;

before(async () => {
  daemon = await Daemon.start();
  browser = await openPlainBrowser();
  page = await openPage(browser, daemon);
  await page.getByRole('tab', {name: 'Scenarios'}).click();
});
after(async () => {
  await browser?.close();
  await stopAll();
});

const field = (id, of = page) => of.getByTestId(id);
const complaint = () => field('fault-complaint').textContent();
const time = async (of = page) => {
  return Number.parseFloat(await field('sim-time', of).textContent());
};

test('every kind that the daemon has can be chosen, with its ranges', async () => {
  const kinds = await field('fault-kind').locator('option').allTextContents();
  assert.ok(kinds.length >= 50, `${kinds.length} kinds`);
  await field('fault-kind').selectOption('joint-weak');
  assert.deepEqual(await field('target-0').locator('option').allTextContents(), [
    'fanuc',
    'motoman'
  ]);
  assert.equal(await field('target-1').locator('option').count(), 6);
  await field('target-0').selectOption('motoman');
  assert.equal(await field('target-1').locator('option').count(), 7);
  assert.equal(await field('parameter-share').getAttribute('placeholder'), '0.3');
  assert.match(
    await page.getByLabel(/^share/).evaluate((i) => i.closest('label').textContent),
    /0.01 to 1/
  );
});

test('what the daemon refuses is told in its words', async () => {
  await field('parameter-share').fill('7');
  await field('inject').click();
  await until('a refusal', async () =>
    /share is 7, must be within 0.01 to 1/.test(await complaint())
  );
  await field('parameter-share').fill('a bit');
  await field('inject').click();
  await until('a complaint', async () => /“a bit” is not a number/.test(await complaint()));
  assert.equal(await page.locator('.fault-line').isVisible(), false);
});

test('a fault begins at once, is on the timeline, and ends by its button', async () => {
  await field('fault-kind').selectOption('robot-slow');
  await field('target-0').selectOption('motoman');
  await field('parameter-share').fill('0.5');
  const begin = await time();
  await field('inject').click();
  const line = await until('the fault', async () => {
    const entry = page.locator('[data-testid=injected-faults] > li[data-state=lasts]');
    return (await entry.count()) === 1 && entry;
  });
  assert.match(await line.textContent(), /robot-slow motoman/);
  const [id] = (await line.getAttribute('data-testid')).match(/\d+/);
  assert.equal(await field('timeline-' + id).getAttribute('data-state'), 'lasts');
  assert.match(await field('timeline-' + id).getAttribute('title'), /share 0.5/);
  const since = Number(
    (
      await field('timeline-' + id)
        .locator('small')
        .textContent()
    ).match(/since ([\d.]+) s/)[1]
  );
  assert.ok(since >= begin, `since ${since}, asked at ${begin}`);
  await line.getByRole('button').click();
  await until(
    'its end',
    async () => (await field('timeline-' + id).getAttribute('data-state')) === 'over'
  );
  await until('an empty list', async () =>
    /No fault is pending/.test(await field('injected-faults').textContent())
  );
  const [, from, to] = (
    await field('timeline-' + id)
      .locator('small')
      .textContent()
  ).match(/([\d.]+) s, to ([\d.]+) s/);
  assert.ok(Number(from) === since && Number(to) > since, `${from} to ${to}`);
});

test('a fault waits for a time, and for an event that the page reports', async () => {
  await field('fault-kind').selectOption('belt-jam');
  await field('trigger').selectOption('at');
  await field('trigger-time').fill(String(Math.ceil(await time()) + 1));
  await field('fault-duration').fill('0.5');
  await field('inject').click();
  await until('the fault over', async () => {
    const rows = await page.locator('.fault-line li').allTextContents();
    return rows.some((row) => /belt-jam.*at \d+ s, to/.test(row));
  });
  await field('fault-duration').fill('');
  await field('trigger').selectOption('reported');
  await field('trigger-event').fill('order-submitted');
  await field('inject').click();
  const waiting = page.locator('[data-testid=injected-faults] > li[data-state=waits]');
  await until('a fault that waits', async () => (await waiting.count()) === 1);
  assert.match(await waiting.textContent(), /waits, when order-submitted is reported/);
  await field('event-name').fill('order-submitted');
  await field('report-event').click();
  await until('its begin', async () =>
    /belt-jam/.test(
      await page.locator('[data-testid=injected-faults] > li[data-state=lasts]').textContent()
    )
  );
});

test('a page that comes later sees what has been, and a reset ends it', async () => {
  const other = await openPage(browser, daemon);
  await until('the past', async () => (await other.locator('.fault-line li').count()) === 3);
  const rows = await other.locator('.fault-line li').allTextContents();
  assert.match(rows[2], /robot-slow motoman/);
  await field('reset', other).click();
  await field('reset-confirm', other).click();
  await until('an empty timeline', async () => !(await other.locator('.fault-line').isVisible()));
  await other.close();
  assert.deepEqual(page.complaints, []);
});

const now = (of = page) => field('program-state', of).textContent();
const speed = async (robot) => Number.parseFloat(await field(`speed-${robot}`).textContent());

test('the demo moves a robot within ten seconds, tells how far its kits are, and stops', async () => {
  assert.match(await now(), /nothing is running/);
  assert.ok(await field('stop-program').isDisabled());
  const begin = await time();
  await field('run-demo').click();
  const moved = await until('motion', async () => {
    const at = await time();
    return ((await speed('fanuc')) > 0 || (await speed('motoman')) > 0) && at;
  });
  assert.ok(moved - begin < 10, `asked at ${begin} s, moves at ${moved} s`);
  await until('parts that are placed', async () => /demo running: [1-9]/.test(await now()), 180000);
  assert.ok((await field('orders').locator('li').count()) >= 2);
  const parts = await field('orders')
    .locator('progress')
    .evaluateAll((bars) => bars.reduce((sum, {value}) => sum + value, 0));
  assert.ok(parts >= 1, `${parts} parts in kits`);
  assert.ok(await field('run-scenario').isDisabled());
  assert.match(await field('run-scenario').getAttribute('title'), /demo is running; stop it first/);
  await field('stop-program').click();
  await until('its end', async () => /demo: stopped/.test(await now()));
  await until('rest', async () => (await speed('fanuc')) === 0 && (await speed('motoman')) === 0);
});

test('a scenario runs in the cell: orders, its faults on the timeline, its report', async () => {
  await field('scenario').selectOption('part_missing');
  await field('seed').fill('a few');
  await field('run-scenario').click();
  const refusal = field('program-complaint');
  await until('a complaint', async () =>
    /“a few” is not a whole number/.test(await refusal.textContent())
  );
  await field('seed').fill('3');
  await field('run-scenario').click();
  await until('its faults', async () => {
    const rows = await page.locator('.fault-line li').allTextContents();
    return (
      rows.filter((row) => /part-missing part_medium_gear_[13].*at 2\./.test(row)).length === 2
    );
  });
  await until('its end', async () => /part_missing: done/.test(await now()), 300000);
  assert.match(await field('orders').textContent(), /table_kit.*done: 1 of 1 kits/);
  const report = await field('program-report').textContent();
  assert.match(report, /kept +kits_right 1, expected 1/);
  assert.match(report, /seed 3\b/);
  assert.deepEqual(page.complaints, []);
});

test('a page where programs are not to be started says so', async () => {
  const other = await Daemon.start(['--set', 'web.programs=false']);
  const view = await openPage(browser, other);
  await view.getByRole('tab', {name: 'Scenarios'}).click();
  await until('a reason', async () => /starts no programs/.test(await now(view)));
  assert.ok(await field('run-demo', view).isDisabled());
  assert.ok(await field('inject', view).isEnabled());
  await other.stop();
});
