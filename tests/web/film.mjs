// Takes the pictures of the README's film: the default cell during its demo, as the page shows it.
// usage: node tests/web/film.mjs FOLDER [SECONDS] [WIDTHxHEIGHT] [PICTURES_PER_S]
//   SECONDS of simulated time. The cell runs slowly, so that drawing without a GPU keeps up.
import {spawn} from 'node:child_process';
import {mkdirSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {bin, Daemon, openBrowser, openPage, until} from './harness.mjs';

const kPace = 0.05;
const kFirst_s = 2;
const [folder, seconds = '18', size = '720x450', rate = '4'] = process.argv.slice(2);
const [width, height] = size.split('x').map(Number);

mkdirSync(folder, {recursive: true});
const daemon = await Daemon.start(['--speed', String(kPace)]);
const browser = await openBrowser();
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
const ports = join(daemon.directory, 'ports.json');
const demo = spawn(join(bin, 'aprsim'), ['--ports-file', ports, 'demo'], {stdio: 'ignore'});
try {
  // The page's own picture from a time on, without waiting for the browser to show it.
  const picture = (due_s) =>
    page.evaluate((due_s) => {
      const {view} = document.querySelector('main.stage');
      const time = view.taken?.simTime;
      const sim_time_s = time ? Number(time.seconds) + time.nanos * 1e-9 : 0;
      if (sim_time_s < due_s) return null;
      view.renderer.shadowMap.needsUpdate = true;
      view.render();
      const png = view.renderer.domElement.toDataURL('image/png').split(',')[1];
      return {png, sim_time_s};
    }, due_s);
  const times = [];
  for (let k = 0; k < Number(seconds) * Number(rate); ++k) {
    const due_s = kFirst_s + k / Number(rate);
    const {png, sim_time_s} = await until(`${due_s} s`, () => picture(due_s), 300000);
    const file = `${String(k).padStart(4, '0')}.png`;
    writeFileSync(join(folder, file), Buffer.from(png, 'base64'));
    times.push({file, sim_time_s});
  }
  writeFileSync(join(folder, 'times.json'), JSON.stringify(times));
} finally {
  demo.kill();
  await browser.close();
  await daemon.stop();
}
