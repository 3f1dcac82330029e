// Takes the pictures of the README's film: the default cell during its demo, as the page shows it.
// usage: node tests/web/film.mjs FOLDER [SECONDS] [WIDTHxHEIGHT] [PICTURES_PER_S] [FIRST_S]
//   SECONDS of simulated time from FIRST_S on; as far as the demo lasts.
// The demo runs before the browser starts. The pictures show its recorded past, so that their times
// are exact at any speed of drawing.
import {execFileSync, spawn} from 'node:child_process';
import {once} from 'node:events';
import {mkdirSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {bin, Daemon, openBrowser, openPage, until} from './harness.mjs';

const kStep_s = 0.001;
const [folder, seconds = '24', size = '720x450', rate = '5', first_s = '2'] = process.argv.slice(2);
const [width, height] = size.split('x').map(Number);

mkdirSync(folder, {recursive: true});
const daemon = await Daemon.start();
const client = ['--ports-file', join(daemon.directory, 'ports.json')];
const demo = spawn(join(bin, 'aprsim'), [...client, 'demo'], {stdio: 'ignore'});
let browser;
try {
  const [code] = await once(demo, 'exit');
  if (code !== 0) throw new Error(`the demo has ended with ${code}`);
  execFileSync(join(bin, 'aprsim'), [...client, 'pause']);
  browser = await openBrowser();
  const page = await openPage(browser, daemon, {
    query: '?quality=fine',
    viewport: {width, height},
    colorScheme: 'light',
    bypassCSP: true
  });
  // The view alone, over the whole window.
  await page.addStyleTag({
    content: `#app > :not(main.stage) { display: none !important }
      main.stage { position: fixed !important; inset: 0; width: 100vw; height: 100vh; z-index: 99 }
      .stage > :not(canvas) { display: none !important }`
  });
  await page.evaluate(() => {
    const {view} = document.querySelector('main.stage');
    view.atHome = false;
    view.setLayer('curtain', false);
    const target = view.controls.target.set(0, -0.55, 1.05);
    view.camera.position.set(1.35, -3.0, 2.3);
    view.camera.lookAt(target);
    view.controls.update();
    window.dispatchEvent(new Event('resize'));
  });
  await until('shadows and reflections', () =>
    page.evaluate(() => {
      const {view} = document.querySelector('main.stage');
      return view.scene.environment !== null && !view.dirty;
    })
  );
  const last = await until('the length of the run', () =>
    page.evaluate(() => Number(document.querySelector('main.stage').view.state.live?.step))
  );
  const show = (step) =>
    page.evaluate((step) => {
      const {state} = document.querySelector('main.stage').view;
      const {epoch} = state.live;
      state.pastReader.ask({epoch, step: BigInt(step)}, (past) => state.showPast(past));
    }, step);
  // The page's own picture of a step, without waiting for the browser to show it.
  const picture = (step) =>
    page.evaluate((step) => {
      const {view} = document.querySelector('main.stage');
      if (Number(view.state.past?.step) !== step) return null;
      view.renderer.shadowMap.needsUpdate = true;
      view.render();
      return view.renderer.domElement.toDataURL('image/png').split(',')[1];
    }, step);
  const times = [];
  for (let k = 0; k < Number(seconds) * Number(rate); ++k) {
    const sim_time_s = Number(first_s) + k / Number(rate);
    const step = Math.round(sim_time_s / kStep_s);
    if (step > last) break;
    await show(step);
    const png = await until(`step ${step}`, () => picture(step));
    const file = `${String(k).padStart(4, '0')}.png`;
    writeFileSync(join(folder, file), Buffer.from(png, 'base64'));
    times.push({file, sim_time_s});
  }
  writeFileSync(join(folder, 'times.json'), JSON.stringify(times));
} finally {
  demo.kill();
  await browser?.close();
  await daemon.stop();
}
