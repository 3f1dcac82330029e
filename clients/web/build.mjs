// Bundles the page: installs the packages when the lock file has changed, generates the messages
// from proto/, bundles src/ and packs the result.
// usage: node build.mjs [--install | --generate] [--out DIRECTORY] [--protoc PROGRAM]
//   --install   stops after the packages, --generate after the messages
import {execFileSync} from 'node:child_process';
import {createHash} from 'node:crypto';
import {
  cpSync,
  existsSync,
  mkdirSync,
  readFileSync,
  readdirSync,
  rmSync,
  writeFileSync
} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {gzipSync} from 'node:zlib';

const here = dirname(fileURLToPath(import.meta.url));
const option = (name, fallback) => {
  const at = process.argv.indexOf(name);
  return at < 0 ? fallback : process.argv[at + 1];
};
const out = option('--out', join(here, '../../build/web'));
const protoc = option('--protoc', 'protoc');

function installPackages() {
  const lock = createHash('sha256')
    .update(readFileSync(join(here, 'package-lock.json')))
    .digest('hex');
  const stamp = join(here, 'node_modules/.lock-hash');
  if (existsSync(stamp) && readFileSync(stamp, 'utf8') === lock) return;
  execFileSync('npm', ['ci', '--ignore-scripts', '--no-audit', '--no-fund', '--loglevel=error'], {
    cwd: here,
    stdio: 'inherit'
  });
  writeFileSync(stamp, lock);
}

function generateMessages() {
  const proto = join(here, '../../proto');
  const generated = join(here, 'generated');
  mkdirSync(generated, {recursive: true});
  const files = readdirSync(join(proto, 'aprsim/v1')).filter(
    (name) => !name.includes('_service') || /^(control|history)_service/.test(name)
  );
  execFileSync(
    protoc,
    [
      '-I',
      proto,
      `--plugin=protoc-gen-es=${join(here, 'node_modules/.bin/protoc-gen-es')}`,
      `--es_out=${generated}`,
      '--es_opt=target=ts',
      ...files.map((name) => join(proto, 'aprsim/v1', name))
    ],
    {stdio: 'inherit'}
  );
}

async function bundle() {
  const {build} = await import('esbuild');
  rmSync(out, {recursive: true, force: true});
  mkdirSync(out, {recursive: true});
  await build({
    entryPoints: {app: join(here, 'src/main.ts'), style: join(here, 'src/style.css')},
    outdir: out,
    bundle: true,
    minify: true,
    format: 'esm',
    target: 'es2020',
    legalComments: 'none',
    logLevel: 'warning'
  });
  // `aprsim trace export --html` writes this script and the page's style into one file.
  await build({
    entryPoints: {player: join(here, 'src/player/main.ts')},
    outdir: join(out, 'player'),
    bundle: true,
    minify: true,
    format: 'iife',
    target: 'es2020',
    legalComments: 'none',
    logLevel: 'warning'
  });
  for (const name of readdirSync(join(here, 'static')))
    cpSync(join(here, 'static', name), join(out, name));
  // For the fields of the editors.
  cpSync(join(here, '../../world/scenes/scene.schema.json'), join(out, 'scene.schema.json'));
  cpSync(
    join(here, '../../world/scenarios/scenario.schema.json'),
    join(out, 'scenario.schema.json')
  );
  const licences = ['three', 'urdf-loader', 'uplot', 'yaml', '@bufbuild/protobuf'].map((name) => {
    const folder = join(here, 'node_modules', name);
    const file = readdirSync(folder).find((entry) => /^licen[cs]e/i.test(entry));
    const {version, license} = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
    return `${name} ${version} (${license})\n\n${file ? readFileSync(join(folder, file), 'utf8') : ''}\n`;
  });
  writeFileSync(join(out, 'licences.txt'), licences.join('\n----\n\n'));
  for (const name of readdirSync(out)) {
    if (/\.(js|css|html|svg|json)$/.test(name)) {
      writeFileSync(join(out, name + '.gz'), gzipSync(readFileSync(join(out, name)), {level: 9}));
    }
  }
}

installPackages();
if (!process.argv.includes('--install')) generateMessages();
if (!process.argv.includes('--install') && !process.argv.includes('--generate')) await bundle();
