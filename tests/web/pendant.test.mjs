// The pendants of the page: choosing a robot, jogging it by hand, sending it where something is.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {CrclClient, Daemon, openBrowser, openPage, stopAll, until} from './harness.mjs';
import {countColors} from './pixels.mjs';

let daemon, browser, page;

before(async () => {
  daemon = await Daemon.start();
  browser = await openBrowser();
  page = await openPage(browser, daemon);
});
after(async () => {
  await browser?.close();
  await stopAll();
});

const value = async (id, of = page) => Number.parseFloat(await of.getByTestId(id).textContent());
const text = (id, of = page) => of.getByTestId(id).textContent();
const robot = (index, of = page) =>
  of.evaluate((i) => {
    const state = document.querySelector('main.stage').view.state.snapshot.robots[i];
    const {x, y, z} = state.toolInReference.positionM;
    return {
      tool: [x, y, z],
      joints: state.joints.map((joint) => joint.positionRad),
      moving: state.moving,
      initialized: state.initialized,
      description: state.action.description
    };
  }, index);
const atRest = (index) => until('rest', async () => !(await robot(index)).moving);
/** A line that is refused as it is let go makes the robot unready for a moment. */
const untilReady = (index) =>
  until('the robot to be ready', async () => {
    const {initialized, description} = await robot(index);
    if (!initialized) throw new Error(`it says "${description}"`);
    return true;
  });

async function makeReady(name, of = page) {
  await of.getByTestId(`choose-${name}`).click();
  await of.getByTestId(`init-${name}`).click();
  await until('a ready robot', () => of.getByTestId(`jog ${name} joint 1 plus`).isEnabled());
}

/** Whether the whole of something can be seen and nothing lies over its middle. */
const inView = (id, of) =>
  of.getByTestId(id).evaluate((element) => {
    const {left, right, top, bottom} = element.getBoundingClientRect();
    const inside = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
    const over = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
    return inside && right > left && (element === over || element.contains(over));
  });

test('status, speed and Stop of every robot are in view on every panel, on a phone too', async () => {
  const phone = await openPage(browser, daemon, {viewport: {width: 390, height: 844}});
  for (const of of [page, phone]) {
    for (const panel of ['Conveyor', 'CRCL', 'Modbus', 'Charts', 'Faults', 'Robots']) {
      await of.getByRole('tab', {name: panel}).click();
      await of.locator('.panel:not([hidden])').evaluate((p) => p.scrollTo(0, p.scrollHeight));
      for (const name of ['fanuc', 'motoman'])
        for (const part of ['state', 'speed', 'stop'])
          await until(`${part} of ${name} under ${panel} in view`, () =>
            inView(`${part}-${name}`, of)
          );
    }
    await until('speed of jogs in view', () => inView('jog-speed', of));
  }
  assert.deepEqual(phone.complaints, []);
  await phone.context().close();
});

test('one pendant at a time, that of the chosen robot', async () => {
  await page.getByTestId('choose-motoman').click();
  assert.ok(await page.getByTestId('robot-motoman').isVisible());
  assert.ok(await page.getByTestId('robot-fanuc').isHidden());
  assert.equal(await page.getByTestId('choose-motoman').getAttribute('aria-pressed'), 'true');
  await page.locator('body').press('r');
  assert.ok(await page.getByTestId('robot-fanuc').isVisible());
  assert.equal(await page.getByTestId('choose-motoman').getAttribute('aria-pressed'), 'false');
  await page.getByRole('tab', {name: 'Conveyor'}).click();
  await page.getByTestId('choose-motoman').click();
  assert.ok(await page.getByTestId('robot-motoman').isVisible(), 'its panel opens');
});

/** Highest speed of the tool while a jog is held until it has moved so far. */
async function fastest(index, button, moved) {
  await page.evaluate((i) => {
    const {state} = document.querySelector('main.stage').view;
    globalThis.fastest = 0;
    state.snapshotChanged.on(({robots}) => {
      const {x, y, z} = robots[i].toolVelocityMS;
      globalThis.fastest = Math.max(globalThis.fastest, Math.hypot(x, y, z));
    });
  }, index);
  await page.getByTestId(button).hover();
  const start = await robot(index);
  await page.mouse.down();
  await until('motion', async () => {
    const now = await robot(index);
    if (!moved(start, now)) throw new Error(`the robot says "${now.description}"`);
    return true;
  });
  await page.mouse.up();
  await atRest(index);
  await untilReady(index);
  return page.evaluate(() => globalThis.fastest);
}

test('at the highest speed jogs move the tool at 0.25 m/s and no faster', async () => {
  await makeReady('motoman');
  assert.equal(await text('jog-speed-text'), '250 mm/s');
  const joint = await fastest(
    1,
    'jog motoman joint 1 plus',
    (a, b) => b.joints[0] > a.joints[0] + 0.5
  );
  assert.ok(joint > 0.2 && joint < 0.2505, `by joint 1: ${joint} m/s`);
  // Away from the singular posture of home, where a line that is interrupted is refused.
  await fastest(1, 'jog motoman joint 2 plus', (a, b) => b.joints[1] > a.joints[1] + 0.2);
  const along = await fastest(1, 'jog motoman along +z', (a, b) => b.tool[2] > a.tool[2] + 0.12);
  assert.ok(along > 0.2 && along < 0.2505, `along z: ${along} m/s`);
  await page.getByTestId('jog-speed').fill('20');
  assert.equal(await text('jog-speed-text'), '50 mm/s');
  const slow = await fastest(1, 'jog motoman along -z', (a, b) => b.tool[2] < a.tool[2] - 0.03);
  assert.ok(slow > 0.04 && slow < 0.0501, `at 20 %: ${slow} m/s`);
  await page.getByTestId('jog-speed').fill('100');
});

test('a jog goes on when the page moves its button, and ends where the finger leaves it', async () => {
  await makeReady('fanuc');
  const jog = page.getByTestId('jog fanuc joint 1 plus');
  await jog.hover();
  await page.mouse.down();
  await until('motion', async () => (await robot(0)).moving);
  const {joints} = await robot(0);
  await page.evaluate(() => {
    for (const of of document.querySelectorAll('.description'))
      Object.assign(of.style, {display: 'block', height: '120px'});
  });
  await until('more of it', async () => (await robot(0)).joints[0] > joints[0] + 0.2);
  assert.match(await jog.getAttribute('class'), /held/);
  await page.mouse.move(20, 300);
  await atRest(0);
  assert.doesNotMatch(await jog.getAttribute('class'), /held/);
  await page.mouse.up();
  await page.evaluate(() => {
    for (const of of document.querySelectorAll('.description')) of.removeAttribute('style');
  });
});

test('a click is one step, also when they come quickly', async () => {
  await makeReady('fanuc');
  await page.getByTestId('jog-step').selectOption('1 mm, 1 deg');
  const start = await robot(0);
  const down = page.getByTestId('jog fanuc along -z');
  for (let i = 0; i < 5; ++i) await down.click();
  await until('the steps to be made', async () => !/held/.test(await down.getAttribute('class')));
  const lower = await until('five millimetres', async () => {
    const now = await robot(0);
    return Math.abs(now.tool[2] - start.tool[2] + 0.005) < 1e-6 && now;
  });
  assert.ok(Math.abs(lower.tool[0] - start.tool[0]) < 1e-6);
  const joint = page.getByTestId('jog fanuc joint 1 plus');
  await joint.focus();
  await page.keyboard.press('Enter');
  await until('one degree', async () => {
    const [first] = (await robot(0)).joints;
    return Math.abs(first - lower.joints[0] - Math.PI / 180) < 1e-6;
  });
  await until('the step to be made', async () => !/held/.test(await joint.getAttribute('class')));
});

test('a step that cannot be made says why in the chosen units and leaves the robot ready', async () => {
  await makeReady('fanuc');
  await page.getByLabel('Unit of angles').selectOption('rad');
  await page.getByTestId('jog-step').selectOption('50 mm, 0.25 rad');
  const joint = page.getByTestId('jog fanuc joint 5 minus');
  const toast = page.locator('.toast.error', {hasText: 'limit'}).last();
  await until('a refusal', async () => {
    if (await toast.isVisible()) return true;
    if (!/held/.test(await joint.getAttribute('class'))) await joint.click();
    return false;
  });
  assert.match(await toast.textContent(), /joint_?5.* rad .*limit -2\.1817 rad/i);
  await until('a ready robot', () => joint.isEnabled());
  await page.getByLabel('Unit of angles').selectOption('deg');
  await page.getByTestId('jog-step').selectOption('while held');
});

test('a picked object is where the pendant has it, and becomes its target', async () => {
  await makeReady('fanuc');
  const gear = await page.evaluate(() => {
    const {view} = document.querySelector('main.stage');
    const {cell, snapshot} = view.state;
    const index = cell.bodies.findIndex((body) => body.name === 'large_gear_vessel_1');
    view.select({kind: 'body', index});
    view.onPick({kind: 'body', index});
    // The daemon's camera sees it in the frame of its vision, by default the CRCL frame.
    const seen = snapshot.robots[0].vision.detections.find(
      (d) => d.body === cell.bodies[index].name
    );
    return {name: cell.bodies[index].name, x: seen?.xM, y: seen?.yM};
  });
  const facts = await until('its place', async () =>
    /for fanuc(-?[\d.]+), (-?[\d.]+), (-?[\d.]+) mm/.exec(await text('pick'))
  );
  const [x, y, z] = facts.slice(1).map(Number);
  assert.ok(Math.abs(x - 1e3 * gear.x) < 2, `x ${x} mm, seen at ${1e3 * gear.x}`);
  assert.ok(Math.abs(y - 1e3 * gear.y) < 2, `y ${y} mm, seen at ${1e3 * gear.y}`);
  assert.ok(Math.abs(z + 9.5) < 0.1, `z ${z} mm`); // as the README has it
  await page.getByRole('tab', {name: 'Charts'}).click();
  await page.getByTestId('pick-to-target').click();
  const target = (name) => page.getByTestId(`fanuc-target-${name}`).inputValue();
  assert.deepEqual((await Promise.all(['x', 'y', 'z'].map(target))).map(Number), [x, y, z]);
  for (const angle of ['roll', 'pitch', 'yaw']) assert.notEqual(await target(angle), '');
  assert.ok(await page.getByTestId('robot-fanuc').isVisible(), 'the pendant opens');
  // Another unit, the same place.
  await page.getByLabel('Unit of lengths').selectOption('in');
  assert.ok(Math.abs(Number(await target('x')) - x / 25.4) < 1e-4);
  await until('inches in the card', async () => / in/.test(await text('pick')));
  // And over it, where the robot can go.
  await page.getByTestId('fanuc-target-z').fill(String(150 / 25.4));
  await page.getByTestId('fanuc-go').click();
  await until('the robot over the gear', async () => {
    const {tool} = await robot(0);
    return Math.hypot(tool[0] - x / 1e3, tool[1] - y / 1e3, tool[2] - 0.15) < 1e-4;
  });
  // The other robot's frame.
  await page.getByTestId('choose-motoman').click();
  await until('the other frame', async () => /for motoman/.test(await text('pick')));
  await page.getByTestId('pick').getByRole('button', {name: 'Close'}).click();
});

test('a robot that refuses says so in the chosen units, and is marked until it is ready', async () => {
  await makeReady('fanuc');
  await page.getByLabel('Unit of lengths').selectOption('in');
  for (const name of ['x', 'y', 'z', 'roll', 'pitch', 'yaw'])
    await page.getByTestId(`fanuc-target-${name}`).fill('0');
  const mark = page.getByTestId('mark-fanuc');
  assert.ok(await mark.isHidden());
  const look = () => page.locator('.stage canvas').screenshot();
  await atRest(0);
  const before = await look();
  await page.getByTestId('fanuc-target-x').fill('60');
  await page.getByTestId('fanuc-go').click();
  await until('the error', async () => (await text('state-fanuc')) === 'error');
  const raw = (await robot(0)).description;
  const metres = [...raw.matchAll(/([\d.]+) m\b/g)].map((match) => Number(match[1]));
  assert.ok(metres.length >= 2, raw);
  const shown = await text('robot-fanuc');
  for (const m of metres)
    assert.ok(shown.includes(`${Number((m / 0.0254).toFixed(4))} in`), `${m} m in "${shown}"`);
  assert.equal(await mark.textContent(), 'fanuc: error');
  await until('a sign', () => mark.isVisible());
  await until('a red arm', async () => (await countColors(await look(), before)).changed > 1500);
  const jog = page.getByTestId('jog fanuc joint 1 plus');
  assert.equal(await jog.getAttribute('title'), 'The robot is not ready: make it ready first.');
  await page.getByTestId('init-fanuc').click();
  await until('no sign', () => mark.isHidden());
  await page.getByLabel('Unit of lengths').selectOption('mm');
});

test('a protective stop and drives that are off are marked', async () => {
  // Over the table, as at the start.
  await page.getByTestId('reset').click();
  await page.getByTestId('reset-confirm').click();
  await until('the start', async () => Math.abs((await robot(1)).joints[0]) < 1e-6);
  await makeReady('motoman');
  await page.getByTestId('stop-motoman').click();
  const mark = page.getByTestId('mark-motoman');
  await until('drives off', async () => (await mark.textContent()) === 'motoman: drives off');
  // Motion switches them on again; this one runs into the table.
  await page.getByTestId('jog motoman along -z').evaluate((button) => {
    const press = (type) =>
      button.dispatchEvent(new PointerEvent(type, {button: 0, bubbles: true}));
    press('pointerdown');
    globalThis.release = () => press('pointerup');
  });
  await until('a protective stop', async () => (await text('state-motoman')) === 'protective stop');
  await page.evaluate(() => globalThis.release());
  assert.equal(await mark.textContent(), 'motoman: protective stop');
  await until('the arm to back off', async () => !(await robot(1)).moving);
  await page.getByTestId('init-motoman').click();
  await until('no sign', () => mark.isHidden());
});

test('the way of planning is chosen, and a checked motion has a path that is drawn', async () => {
  await makeReady('motoman');
  const planning = page.getByTestId('planning-motoman');
  assert.equal(await planning.inputValue(), '1');
  const other = await openPage(browser, daemon);
  await planning.selectOption({label: 'go round obstacles'});
  await other.getByTestId('choose-motoman').click();
  await until(
    'the choice on another page',
    async () => (await other.getByTestId('planning-motoman').inputValue()) === '3'
  );
  await other.close();
  // Jogs are not checked; moves of a controller are.
  const client = await CrclClient.open(daemon.ports['crcl.motoman']);
  await client.run('InitCanonType');
  client.send(
    'ActuateJointsType',
    '<ActuateJoint><JointNumber>7</JointNumber><JointPosition>20</JointPosition><JointDetails xsi:type="JointSpeedAccelType"><JointSpeed>5</JointSpeed></JointDetails></ActuateJoint>'
  );
  await until('a path', () =>
    page.evaluate(
      () =>
        document.querySelector('main.stage').view.state.snapshot.robots[1].plannedPathM.length > 1
    )
  );
  await client.run('StopMotionType', '<StopCondition>Normal</StopCondition>');
  client.close();
  await atRest(1);
  await planning.selectOption({label: 'direct moves'});
  await until('the choice', () =>
    page.evaluate(
      () => document.querySelector('main.stage').view.state.snapshot.robots[1].planning === 1
    )
  );
});

test('a robot that is stopped from elsewhere is marked though out of the picture', async () => {
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  await assert.rejects(client.moveJoints([500, 0, 0, 0, 0, 0]));
  client.close();
  await page.getByTestId('look-motoman').click();
  await until('the sign', () => page.getByTestId('mark-fanuc').isVisible());
  assert.ok(
    await page.getByTestId('mark-fanuc').evaluate((sign) => {
      const at = sign.getBoundingClientRect(),
        stage = document.querySelector('main.stage').getBoundingClientRect();
      return (
        at.left >= stage.left &&
        at.right <= stage.right &&
        at.top >= stage.top &&
        at.bottom <= stage.bottom
      );
    })
  );
  await makeReady('fanuc');
});

test('on a phone the view stays while the last jog button is used', async () => {
  const phone = await openPage(browser, daemon, {viewport: {width: 390, height: 844}});
  await makeReady('fanuc', phone);
  const stage = () => phone.locator('main.stage').boundingBox();
  const before = await stage();
  assert.ok(before.height > 150, `the view is ${before.height} high`);
  const button = phone.getByTestId('jog fanuc about +z');
  await phone.getByTestId('jog-step').selectOption('1 mm, 1 deg');
  await button.scrollIntoViewIfNeeded();
  await button.click();
  await until('the step to be made', async () => !/held/.test(await button.getAttribute('class')));
  assert.deepEqual(await stage(), before);
  assert.equal(await phone.evaluate(() => scrollY), 0);
  assert.deepEqual(phone.complaints, []);
  await phone.context().close();
});

test('a line that is let go at any moment, refused or not, leaves the robot ready', async () => {
  await makeReady('motoman');
  // Up first: how far it goes is a matter of the machine's pace, and trays stand beside it.
  for (const direction of ['+z', '+x', '+y']) {
    await page.getByTestId(`jog motoman along ${direction}`).hover();
    for (let hold_ms = 0; hold_ms <= 400; hold_ms += 50) {
      await page.mouse.down();
      await new Promise((go) => setTimeout(go, hold_ms));
      await page.mouse.up();
      await atRest(1);
      await untilReady(1);
    }
  }
});

test('nothing was complained of', () => assert.deepEqual(page.complaints, []));
