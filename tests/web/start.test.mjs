// The first minutes at the page: where to start, in any width, without WebGL, in a paused cell.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {
  Daemon,
  openBrowser,
  openPage,
  openPlainBrowser,
  stopAll,
  until,
  writeRegister
} from './harness.mjs';

let browser, plain; // with and without WebGL
before(async () => {
  browser = await openBrowser();
  plain = await openPlainBrowser();
});
after(async () => {
  await browser?.close();
  await plain?.close();
  await stopAll();
});

/** Whether all of an element is inside the window and on top of others. */
const isInView = (locator) =>
  locator.evaluate((element) => {
    const {left, right, top, bottom} = element.getBoundingClientRect();
    const inside = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
    const over = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
    return inside && right > left && (element === over || element.contains(over));
  });

test('all tabs and the start are in view at any width, until something has run', async () => {
  const daemon = await Daemon.start();
  const page = await openPage(browser, daemon);
  for (const [width, height] of [
    [1280, 800],
    [1440, 900],
    [1920, 1080],
    [390, 844]
  ]) {
    await page.setViewportSize({width, height});
    await until(`the start at ${width}`, () => isInView(page.getByTestId('start-demo')));
    for (const head of await page.getByRole('tab').all())
      assert.ok(await isInView(head), `${await head.textContent()} at ${width}`);
  }
  await page.getByTestId('start-scenarios').click();
  await until('the panel with scenarios', () => isInView(page.getByTestId('run-demo')));
  await writeRegister(daemon.ports.modbus, 0x8002, 5000);
  await writeRegister(daemon.ports.modbus, 0x8000, 1);
  await until('the start to go', () => page.getByTestId('start').isHidden());
  assert.deepEqual(page.complaints, []);
  await page.context().close();
  await daemon.stop();
});

test('in a paused cell the demo offers to resume', async () => {
  const daemon = await Daemon.start(['--speed', 'stepped']);
  const page = await openPage(plain, daemon);
  await until('the start', () => page.getByTestId('start-demo').isEnabled());
  await page.getByTestId('start-demo').click();
  const dialog = page.getByRole('dialog', {name: 'The cell is paused'});
  await dialog.getByRole('button', {name: 'Cancel'}).click();
  assert.equal(await page.getByTestId('play').textContent(), 'Play', 'nothing was resumed');
  assert.ok(await page.getByTestId('start').isVisible(), 'and nothing started');
  await page.getByTestId('start-demo').click();
  await dialog.getByTestId('resume-and-run').click();
  await until(
    'the cell to run',
    async () => (await page.getByTestId('play').textContent()) === 'Pause'
  );
  await until('the demo to run', () => page.getByTestId('start').isHidden());
  await page.getByTestId('play').click();
  await page.getByRole('tab', {name: 'Scenarios'}).click();
  const waits = page.getByTestId('program-waits');
  await until('an offer to resume', () => waits.isVisible());
  await waits.getByRole('button', {name: 'Resume'}).click();
  await until('the cell to run again', () => waits.isHidden());
  await page.context().close();
  await daemon.stop();
});

test('joints, tool and gripper of either robot fit 1440 x 900 without scrolling', async () => {
  const daemon = await Daemon.start();
  const page = await openPage(plain, daemon, {
    viewport: {width: 1440, height: 900}
  });
  for (const name of ['fanuc', 'motoman']) {
    await page.getByTestId(`choose-${name}`).click();
    const robot = page.getByTestId(`robot-${name}`);
    await robot.waitFor();
    const outside = await robot.evaluate((element) =>
      [...element.querySelectorAll('button, output, input, dd')]
        .filter((part) => part.offsetParent !== null)
        .filter((part) => {
          const {left, right, top, bottom} = part.getBoundingClientRect();
          const over = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
          const covered = over !== part && !part.contains(over);
          return left < 0 || top < 0 || right > innerWidth || bottom > innerHeight || covered;
        })
        .map((part) => part.outerHTML)
    );
    assert.deepEqual(outside, [], name);
    const {scrollHeight, clientHeight} = await page
      .locator('.panel.robots')
      .evaluate(({scrollHeight, clientHeight}) => ({scrollHeight, clientHeight}));
    assert.ok(scrollHeight <= clientHeight, `${name}: ${scrollHeight} of ${clientHeight}`);
  }
  await page.context().close();
  await daemon.stop();
});

test('without WebGL one line is where the view would be, and all else works', async () => {
  const daemon = await Daemon.start();
  const page = await openPage(plain, daemon);
  await until('the line', async () =>
    /does not offer WebGL/.test(await page.getByTestId('no-webgl').textContent())
  );
  const robot = (index) =>
    page.evaluate((i) => {
      const {snapshot} = document.querySelector('main.stage').view.state;
      return {
        ready: snapshot.robots[i].initialized,
        joint: snapshot.robots[i].joints[0].positionRad,
        drives: snapshot.robots[i].drivesOn
      };
    }, index);
  await page.getByTestId('init-fanuc').click();
  await until('a ready robot', async () => (await robot(0)).ready);
  await page.getByTestId('jog-step').selectOption('1 mm, 1 deg');
  await page.getByTestId('jog fanuc joint 1 plus').click();
  await until('one degree', async () => Math.abs((await robot(0)).joint - Math.PI / 180) < 1e-6);
  await page.getByTestId('stop-fanuc').click();
  await until('the drives to stop', async () => !(await robot(0)).drives);
  await page.getByRole('tab', {name: 'CRCL'}).click();
  await until('the commands of the page', async () =>
    /fanuc stop/.test(await page.getByTestId('crcl-rows').textContent())
  );
  await page.getByRole('tab', {name: 'Conveyor'}).click();
  await until('the registers', async () =>
    /speed/.test(await page.getByTestId('registers').textContent())
  );
  await page.getByRole('tab', {name: 'Charts'}).click();
  await until('values in a chart', async () =>
    /\d mm/.test(await page.getByTestId('reading fanuc tool z').textContent())
  );
  await page.getByTestId('past-back').click();
  await until('the past', async () => (await page.getByTestId('rtf').textContent()) === 'past');
  await page.getByTestId('past-now').click();
  assert.deepEqual(page.complaints, []);
  await page.context().close();
  await daemon.stop();
});
