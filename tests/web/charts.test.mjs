// Charts: several signals in one, units on the axes, zoom, the daemon's history, and the timeline.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {bin, CrclClient, Daemon, openPage, openPlainBrowser, stopAll, until} from './harness.mjs';

let daemon, browser, page, opened_s;

before(async () => {
  daemon = await Daemon.start();
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  await client.run('DwellType', '<DwellTime>2</DwellTime>');
  await client.moveJoints([30, 0, 0, 0, -90, 0]);
  client.close();
  // From here on the test's own pace does not matter.
  execFileSync(join(bin, 'aprsim'), ['--ports-file', daemon.portsFile, 'pause']);
  browser = await openPlainBrowser();
  page = await openPage(browser, daemon);
  opened_s = await shownTime();
  await page.getByRole('tab', {name: 'Charts'}).click();
});
after(async () => {
  await browser?.close();
  await stopAll();
});

const shownTime = async () => Number.parseFloat(await page.getByTestId('sim-time').textContent());

async function add(name, chart = '') {
  await page.getByTestId('chart-target').selectOption(chart);
  await page.getByTestId('chart-choice').fill(name);
  await page.getByTestId('chart-choice').press('Enter');
}

/** The values that the charts show: names and rows of numbers, the time first. */
const values = () =>
  page.evaluate(() => {
    const {charts} = document.querySelector('main.stage');
    const {times, rows} = charts.recording;
    const {from_s, to_s} = charts.range;
    return {
      names: ['time', ...charts.signals.map(({name}) => name)],
      rows: times
        .map((time, i) => [time, ...rows[i]])
        .filter(([time]) => time >= from_s - 1e-6 && time <= to_s + 1e-6)
    };
  });

test('charts reach back to before the page was opened', async () => {
  await page.getByTestId('chart-span').selectOption('10 min');
  await add('fanuc J1 position');
  await until(
    'the joint before and after its move',
    async () => {
      const {names, rows} = await values();
      const column = names.indexOf('fanuc J1 position');
      const before = rows.filter(([time]) => time <= opened_s);
      const at = (angle) => before.some((row) => Math.abs(row[column] - angle) < 0.01);
      if (before.length < 60 || !(before[0][0] < 1) || !at(0) || !at(30))
        throw new Error(`${before.length} rows before ${opened_s} s, from ${before[0]?.[0]} s`);
      return true;
    },
    300000
  );
});

test('a chart shows several signals, with two units at most', async () => {
  const chart = page.getByTestId('chart').last();
  await add('motoman J1 position', '3');
  await add('fanuc J1 velocity', '3');
  await until('three readings', async () => (await chart.locator('output').count()) === 3);
  const readings = () => chart.locator('output').allTextContents();
  await until('values', async () => (await readings()).every((text) => /^-?\d+\.\d+ °/.test(text)));
  await add('step time', '3');
  assert.match(
    await page.getByTestId('chart-complaint').textContent(),
    /This chart has the units \[°\] and \[°\/s\]; add step time to another one/
  );
  assert.equal(await page.getByTestId('chart').count(), 4);
});

test('both axes carry their units', async () => {
  const written = await page.evaluate(async () => {
    const texts = new Set();
    const {prototype} = CanvasRenderingContext2D;
    const {fillText} = prototype;
    prototype.fillText = function (text, ...rest) {
      texts.add(text);
      return fillText.call(this, text, ...rest);
    };
    document.querySelector('[data-testid=chart-zoom-in]').click();
    await new Promise((go) => setTimeout(go, 500));
    prototype.fillText = fillText;
    return [...texts];
  });
  for (const label of ['simulated time [s]', '[mm]', '[N]', '[°]', '[°/s]'])
    assert.ok(written.includes(label), `${label} of ${written}`);
  await page.getByTestId('chart-pause').click();
});

const width = async () => {
  const {rows} = await values();
  return rows.at(-1)[0] - rows[0][0];
};

test('charts zoom by buttons and by dragging, and follow again', async () => {
  const all = await width();
  await page.getByTestId('chart-pause').click();
  await page.getByTestId('chart-zoom-in').click();
  const half = await width();
  assert.ok(half < 0.7 * all, `${half} of ${all} s`);
  const over = page.getByTestId('chart').first().locator('.u-over');
  const {x, y, width: w, height: h} = await over.boundingBox();
  await page.mouse.move(x + 0.4 * w, y + h / 2);
  await page.mouse.down();
  await page.mouse.move(x + 0.6 * w, y + h / 2, {steps: 5});
  await page.mouse.up();
  const fifth = await until('a narrower range', async () => {
    const now = await width();
    return now < 0.5 * half && now;
  });
  // Finer values come from the daemon.
  await until('more points', async () => (await values()).rows.length > 50, 300000);
  assert.ok(fifth > 0.05 * half, `${fifth} of ${half} s`);
  await page.getByTestId('chart-pause').click();
  await until('the whole again', async () => (await width()) > 0.9 * all);
});

test('a click in a chart goes to that moment on the timeline', async () => {
  await page.getByTestId('chart-pause').click();
  const {rows} = await values();
  const over = page.getByTestId('chart').first().locator('.u-over');
  const {x, y, width: w, height: h} = await over.boundingBox();
  await page.mouse.click(x + w / 2, y + h / 2);
  const moment = await until('a moment of the past', async () => {
    const time = Number.parseFloat(await page.getByTestId('past-time').textContent());
    return Number.isFinite(time) && time;
  });
  const middle = (rows[0][0] + rows.at(-1)[0]) / 2;
  const all = rows.at(-1)[0] - rows[0][0];
  assert.ok(Math.abs(moment - middle) < 0.06 * all, `${moment} s, clicked at ${middle} s`);
  await page.mouse.move(5, 300);
  await until('the value of the moment', async () =>
    (await page.getByTestId('reading fanuc J1 position').textContent()).startsWith(
      `${moment.toFixed(3)} s: `
    )
  );
  await page.getByTestId('past-now').click();
  assert.deepEqual(page.complaints, []);
});
