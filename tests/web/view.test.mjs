// The view: its direction, resolution, names and labels, and its return after a lost context.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {Daemon, openBrowser, openPage, stopAll, until} from './harness.mjs';
import {countColors} from './pixels.mjs';

let browser;
before(async () => (browser = await openBrowser()));
after(async () => {
  await browser?.close();
  await stopAll();
});

const kShapes = [
  [1200, 800],
  [390, 844],
  [2200, 700],
  [844, 390],
  [700, 1300]
];

/** A place in the picture that nothing covers, as 70 pixels right and 20 below it. */
const uncovered = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector('main.stage canvas');
    const {left, top, right, bottom} = canvas.getBoundingClientRect();
    const isFree = (x, y) => document.elementFromPoint(x, y) === canvas;
    for (let y = top + 5; y < bottom - 25; y += 5)
      for (let x = left + 5; x < right - 75; x += 5)
        if (isFree(x, y) && isFree(x + 70, y + 20)) return [x, y];
    throw new Error('all of the picture is covered');
  });

/** How far outside the picture, in halves of it, the outermost corner of anything drawn is: below 0
 * is inside. `top` is where the picture begins under the buttons. */
const outermost = (page) =>
  page.evaluate(() => {
    const {view} = document.querySelector('main.stage');
    const area = view.renderer.domElement.getBoundingClientRect();
    const buttons = document.querySelector('.layers').getBoundingClientRect();
    const top = 1 - (2 * (buttons.bottom - area.top)) / area.height;
    let most = -Infinity,
      what = '';
    view.scene.updateMatrixWorld(true);
    view.camera.updateMatrixWorld(true);
    const near = (mesh) => {
      const {position} = mesh.geometry.attributes;
      const p = view.camera.position.clone();
      for (let i = 0; i < position.count; ++i) {
        p.fromBufferAttribute(position, i).applyMatrix4(mesh.matrixWorld);
        const behind = p.clone().applyMatrix4(view.camera.matrixWorldInverse).z >= 0;
        p.project(view.camera);
        const out = behind ? 9 : Math.max(Math.abs(p.x) - 1, -1 - p.y, p.y - top);
        if (out > most) [most, what] = [out, mesh.userData.pick?.kind ?? mesh.parent.type];
      }
    };
    for (const thing of [
      ...view.robots.map((robot) => robot.root),
      view.parts.root,
      view.fixed,
      view.belt?.root,
      view.eyes?.root,
      view.curtain?.root
    ])
      thing?.traverseVisible((o) => o.isMesh && near(o));
    return {most, what, distance: view.camera.position.distanceTo(view.controls.target)};
  });

for (const scene of [
  'aprs',
  'aprs_2024',
  'aprs_2025',
  'aprs_lab',
  'fanuc_only',
  'motoman_only',
  'table1',
  'empty_belt'
]) {
  test(`the first view of ${scene} has everything in the picture, whatever its shape`, async () => {
    const daemon = await Daemon.start(['--scene', scene]);
    const page = await openPage(browser, daemon);
    for (const [width, height] of scene === 'aprs' ? kShapes : kShapes.slice(0, 2)) {
      await page.setViewportSize({width, height});
      await until('the picture to fit', async () => {
        const {aspect, shape} = await page.evaluate(() => {
          const {view, clientWidth, clientHeight} = document.querySelector('main.stage');
          return {aspect: view.camera.aspect, shape: clientWidth / clientHeight};
        });
        return Math.abs(aspect - shape) < 1e-6;
      });
      const {most, what} = await outermost(page);
      assert.ok(most < 0, `${what} is ${most} outside at ${width}x${height}`);
      assert.ok(most > -0.3, `all of it is small: ${most} at ${width}x${height}`);
    }
    // A view that someone has chosen stays.
    const [x, y] = await uncovered(page);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 70, y + 20, {steps: 4});
    await page.mouse.up();
    const eye = () =>
      page.evaluate(() => document.querySelector('main.stage').view.camera.position.toArray());
    const chosen = await eye();
    await page.setViewportSize({width: 1000, height: 800});
    await until('the new size', () =>
      page.evaluate(() => {
        const {view, clientWidth, clientHeight} = document.querySelector('main.stage');
        return Math.abs(view.camera.aspect - clientWidth / clientHeight) < 1e-6;
      })
    );
    assert.deepEqual(await eye(), chosen);
    assert.deepEqual(page.complaints, []);
    await page.context().close();
    await daemon.stop();
  });
}

test('the View button shows the front of a robot, past the other one', async () => {
  const daemon = await Daemon.start();
  const page = await openPage(browser, daemon);
  for (const [index, name] of ['fanuc', 'motoman'].entries()) {
    await page.getByTestId(`choose-${name}`).click();
    const look = page.getByTestId(`look-${name}`);
    await look.waitFor();
    const seen = await look.evaluate((button, i) => {
      const {view} = document.querySelector('main.stage');
      button.click(); // no picture comes between this and what is asked of the view
      const {cell, snapshot} = view.state;
      const at = (p) => view.camera.position.clone().set(p.x, p.y, p.z);
      const base = at(cell.robots[i].baseInWorld.positionM),
        tool = at(snapshot.robots[i].toolInWorld.positionM);
      const front = tool.clone().sub(base).setZ(0).normalize(),
        from = view.camera.position.clone().sub(base).setZ(0).normalize();
      const shown = tool.clone().project(view.camera);
      return {cosine: front.dot(from), x: shown.x, y: shown.y};
    }, index);
    assert.ok(
      seen.cosine > 0.5,
      `${name} is seen from ${Math.acos(seen.cosine)} rad off its front`
    );
    assert.ok(Math.abs(seen.x) < 0.9 && Math.abs(seen.y) < 0.9, `${name}'s tool is in the picture`);
  }
  await page.context().close();
  await daemon.stop();
});

test('pictures become coarser where drawing is slow, and finer again where there is room', async () => {
  const daemon = await Daemon.start(['--speed', 'stepped']);
  const page = await openPage(browser, daemon);
  const told = await page.evaluate(() => {
    const {view} = document.querySelector('main.stage');
    const Fineness = view.fineness.constructor;
    const run = (of, from, seconds, picture_ms) => {
      for (let t = from; t < from + 1000 * seconds; t += picture_ms) of.took(picture_ms, t);
      return from + 1000 * seconds;
    };
    const one = new Fineness(2, true);
    let now = run(one, 5000, 30, 80);
    const slow = one.ratio;
    now = run(one, now, 60, 12);
    const again = one.ratio;
    // A machine that is quick enough only for the coarse pictures: rises become rare.
    let rises = 0;
    const limited = new Fineness(2, true);
    now = run(limited, 5000, 30, 80);
    for (const end = now + 600000; now < end; ) {
      const before = limited.ratio;
      const picture_ms = before > 0.5 ? 60 : 16;
      limited.took(picture_ms, now);
      now += picture_ms;
      if (limited.ratio > before) ++rises;
    }
    // The view's own.
    const sizes = [];
    const {renderer} = view;
    const width = () => renderer.domElement.width;
    const later = performance.now() + 1e6;
    for (let i = 0; i < 60; ++i) view.adapt(200, later + 100 * i);
    sizes.push(width());
    for (let i = 0; i < 900; ++i) view.adapt(5, later + 1e5 + 100 * i);
    sizes.push(width());
    return {slow, again, rises, sizes, still: new Fineness(2, false).took(500, 1e6)};
  });
  assert.equal(told.slow, 0.5);
  assert.equal(told.again, 2);
  assert.ok(told.rises >= 1 && told.rises <= 8, `${told.rises} rises in ten minutes`);
  assert.ok(told.sizes[1] > 1.4 * told.sizes[0], `widths: ${told.sizes}`);
  assert.equal(told.still, false);
  await page.context().close();
  await daemon.stop();
});

test('in the first view no post of the light curtain is before robots, trays or gears', async () => {
  const daemon = await Daemon.start();
  for (const [width, height] of kShapes.slice(0, 3)) {
    const page = await openPage(browser, daemon, {viewport: {width, height}});
    const covered = await page.evaluate(() => {
      const {view} = document.querySelector('main.stage');
      view.scene.updateMatrixWorld(true);
      const V = view.camera.position.constructor;
      const eye = view.camera.position;
      // Corners of everything that is worked with, and the line of sight to each.
      const names = [];
      const posts = view.curtain.posts.map((post) => {
        post.geometry.computeBoundingBox();
        return {inverse: post.matrixWorld.clone().invert(), box: post.geometry.boundingBox};
      });
      const isCovered = (point) =>
        posts.some(({inverse, box}) => {
          // Sampled along the line, in the post's own frame.
          const a = eye.clone().applyMatrix4(inverse),
            b = point.clone().applyMatrix4(inverse);
          for (let t = 0; t < 1; t += 0.0005)
            if (box.containsPoint(new V().lerpVectors(a, b, t))) return true;
          return false;
        });
      for (const root of [...view.robots.map((robot) => robot.root), ...view.parts.meshes])
        root.traverse((mesh) => {
          if (!mesh.isMesh) return;
          mesh.geometry.computeBoundingBox();
          const {min, max} = mesh.geometry.boundingBox;
          for (let i = 0; i < 8; ++i) {
            const corner = new V(
              i & 1 ? max.x : min.x,
              i & 2 ? max.y : min.y,
              i & 4 ? max.z : min.z
            );
            if (isCovered(corner.applyMatrix4(mesh.matrixWorld)))
              names.push(mesh.userData.pick?.index ?? mesh.parent.name);
          }
        });
      return names;
    });
    assert.deepEqual(covered, [], `at ${width}x${height}`);
    await page.context().close();
  }
  await daemon.stop();
});

test('the view is drawn again after its WebGL context was lost and restored', async () => {
  const daemon = await Daemon.start(['--speed', 'stepped']); // nothing else asks for a picture
  const page = await openPage(browser, daemon);
  const colors = async () => {
    const {different} = await countColors(await page.locator('.stage canvas').screenshot());
    return different;
  };
  const before = await until('a picture', async () => {
    const now = await colors();
    return now > 200 && now;
  });
  await page.evaluate(() => {
    const gl = document.querySelector('main.stage').view.renderer.getContext();
    globalThis.loss = gl.getExtension('WEBGL_lose_context');
    globalThis.loss.loseContext();
  });
  await until('a word about it', () => page.getByText('lost the graphics context').isVisible());
  await page.evaluate(() => globalThis.loss.restoreContext());
  await until('the picture again', async () => (await colors()) > 0.7 * before);
  assert.ok(await page.getByText('lost the graphics context').isHidden());
  await page.context().close();
  await daemon.stop();
});

test('names of robots, trays and tools can be shown; trays and arms carry labels', async () => {
  const daemon = await Daemon.start();
  const page = await openPage(browser, daemon);
  const names = await page.evaluate(() => {
    const {cell} = document.querySelector('main.stage').view.state;
    const trays = cell.bodies.filter((body) => body.geometry.case === 'tray');
    return [...cell.robots, ...cell.tools, ...trays].map(({name}) => name);
  });
  for (const name of names) assert.ok(await page.getByTestId(`name-${name}`).isHidden(), name);
  await page.getByTestId('layer-names').click();
  for (const name of names)
    await until(`the name ${name}`, () => page.getByTestId(`name-${name}`).isVisible());
  await page.getByTestId('layer-names').click();
  for (const name of names) assert.ok(await page.getByTestId(`name-${name}`).isHidden(), name);
  const labels = await page.evaluate(() => {
    const {view} = document.querySelector('main.stage');
    const lettered = (root) => {
      let count = 0;
      root.traverse((o) => (count += o.isMesh && o.material.map ? 1 : 0));
      return count;
    };
    const {cell} = view.state;
    return {
      trays: cell.bodies.flatMap((body, i) =>
        body.geometry.case === 'tray' ? [lettered(view.parts.meshes[i])] : []
      ),
      arms: view.robots.map((robot) => lettered(robot.root))
    };
  });
  assert.ok(
    labels.trays.every((count) => count === 1),
    `labels of trays: ${labels.trays}`
  );
  assert.ok(
    labels.arms.every((count) => count >= 2),
    `nameplates of arms: ${labels.arms}`
  );
  await page.context().close();
  await daemon.stop();
});
