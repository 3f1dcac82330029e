// The manifests in docker/kubernetes: against Kubernetes' own types and validators, and by kubectl, where
// there is one, with a server of ours that knows which kinds there are and no more.
import assert from 'node:assert/strict';
import {execFile, spawnSync} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {createServer} from 'node:http';
import {tmpdir} from 'node:os';
import path from 'node:path';
import {fileURLToPath, pathToFileURL} from 'node:url';
import {promisify} from 'node:util';
import {describe, test} from 'node:test';
import {parse} from 'yaml';

const here = path.dirname(fileURLToPath(import.meta.url));
const root = path.resolve(here, '../..');
const folder = path.join(root, 'docker/kubernetes');
const read = (name) => parse(readFileSync(path.join(folder, name), 'utf8'));
const kustomization = read('kustomization.yaml');
const manifests = Object.fromEntries(kustomization.resources.map((name) => [name, read(name)]));
const pod = (name) => manifests[name].spec.template.spec;
const modules = {
  Namespace: 'v1/Namespace',
  PersistentVolumeClaim: 'v1/PersistentVolumeClaim',
  Job: 'batch/v1/Job',
};

describe('manifests', () => {
  for (const [name, manifest] of Object.entries(manifests)) {
    test(`${name} is valid`, async () => {
      const module = path.join(here, 'node_modules/kubernetes-models', modules[manifest.kind] + '.mjs');
      const model = (await import(pathToFileURL(module)))[manifest.kind];
      new model(manifest).validate();
      const wrong = structuredClone(manifest);
      wrong.metadata.name = 7;
      assert.throws(() => new model(wrong).validate(), 'the validator looks');
    });
  }

  // Kubernetes ignores fields that it does not know, the compiler does not.
  test('no field is misspelt', () => {
    const directory = mkdtempSync(path.join(here, 'node_modules/.check-'));
    try {
      const check = (text) => {
        writeFileSync(path.join(directory, 'check.ts'), text);
        const tsc = path.join(root, 'clients/web/node_modules/typescript/bin/tsc');
        return spawnSync(
          process.execPath,
          [tsc, '--noEmit', '--strict', '--skipLibCheck', '--module', 'nodenext', '--target', 'es2022']
            .concat('--moduleResolution', 'nodenext', path.join(directory, 'check.ts')),
          {encoding: 'utf8'},
        );
      };
      const declared = (change = (manifest) => manifest) =>
        Object.values(manifests)
          .map((manifest, i) => {
            const text = JSON.stringify(change(structuredClone(manifest)));
            const module = `kubernetes-models/${modules[manifest.kind]}`;
            return (
              `import type {I${manifest.kind} as Kind${i}} from '${module}';\n` +
              `export const manifest${i}: Kind${i} = ${text};\n`
            );
          })
          .join('');
      const good = check(declared());
      assert.equal(good.status, 0, good.stdout);
      const misspelt = check(
        declared((manifest) => {
          if (manifest.kind === 'Job') manifest.spec.template.spec.restartPolcy = 'Never';
          return manifest;
        }),
      );
      assert.match(misspelt.stdout, /restartPolcy/);
    } finally {
      rmSync(directory, {recursive: true});
    }
  });
});

describe('the batch', () => {
  const literals = Object.fromEntries(
    kustomization.configMapGenerator[0].literals.map((line) => line.split(/=(.*)/s).slice(0, 2)),
  );
  const spec = manifests['batch.yaml'].spec;

  test('has as many shards as indexes', () => {
    assert.equal(spec.completionMode, 'Indexed');
    assert.equal(String(spec.completions), literals.SHARDS.trim());
    assert.ok(spec.parallelism <= spec.completions);
    assert.ok(spec.backoffLimitPerIndex > 0);
    const script = pod('batch.yaml').containers[0].args.join(' ');
    assert.match(script, /--shard "\$JOB_COMPLETION_INDEX\/\$SHARDS"/);
    for (const [, name] of script.matchAll(/\$([A-Z_]+)/g)) {
      assert.ok(name === 'JOB_COMPLETION_INDEX' || name in literals, name);
    }
  });

  test('gives up on wrong arguments alone, and counts no disruption', () => {
    const [disruption, wrong, other] = spec.podFailurePolicy.rules;
    assert.deepEqual([disruption.action, wrong.action, other.action], ['Ignore', 'FailJob', 'Count']);
    assert.deepEqual(wrong.onExitCodes.values, [2]);
    for (const rule of [wrong, other]) {
      assert.equal(rule.onExitCodes.containerName, pod('batch.yaml').containers[0].name);
    }
    // Kubernetes demands it beside such a policy.
    assert.equal(pod('batch.yaml').restartPolicy, 'Never');
  });

  test('is what a namespace of restricted pods takes', () => {
    assert.equal(
      manifests['namespace.yaml'].metadata.labels['pod-security.kubernetes.io/enforce'],
      'restricted',
    );
    const user = Number(/useradd.*--uid (\d+)/.exec(readFileSync(path.join(root, 'docker/Dockerfile')))[1]);
    for (const name of ['batch.yaml', 'merge.yaml']) {
      const {securityContext, containers, volumes} = pod(name);
      assert.equal(securityContext.runAsUser, user, 'the user of the image');
      assert.equal(securityContext.runAsNonRoot, true);
      assert.equal(securityContext.seccompProfile.type, 'RuntimeDefault');
      for (const container of containers) {
        assert.equal(container.securityContext.allowPrivilegeEscalation, false);
        assert.equal(container.securityContext.readOnlyRootFilesystem, true);
        assert.deepEqual(container.securityContext.capabilities.drop, ['ALL']);
        assert.ok(container.resources.requests.cpu && container.resources.requests.memory);
        for (const mount of container.volumeMounts) {
          assert.ok(volumes.some((volume) => volume.name === mount.name), mount.name);
        }
      }
    }
  });

  test('keeps its results in the claim', () => {
    const claims = pod('batch.yaml').volumes.map((volume) => volume.persistentVolumeClaim?.claimName);
    assert.ok(claims.includes(manifests['results.yaml'].metadata.name));
  });
});

/** The discovery documents that kubectl requests first. */
function discovery() {
  const list = (groupVersion, resources) => ({
    kind: 'APIResourceList',
    apiVersion: 'v1',
    groupVersion,
    resources: resources.map(([name, kind, namespaced]) => ({
      ...{name, kind, namespaced, singularName: '', verbs: ['create', 'get', 'list', 'patch']},
    })),
  });
  const version = {groupVersion: 'batch/v1', version: 'v1'};
  const answers = {
    '/api': {kind: 'APIVersions', versions: ['v1']},
    '/apis': {
      ...{kind: 'APIGroupList', apiVersion: 'v1'},
      groups: [{name: 'batch', versions: [version], preferredVersion: version}],
    },
    '/api/v1': list('v1', [
      ['namespaces', 'Namespace', false],
      ['configmaps', 'ConfigMap', true],
      ['persistentvolumeclaims', 'PersistentVolumeClaim', true],
    ]),
    '/apis/batch/v1': list('batch/v1', [['jobs', 'Job', true]]),
  };
  const asked = [];
  const server = createServer((request, response) => {
    const answer = answers[new URL(request.url, 'http://cell').pathname];
    asked.push(`${request.method} ${request.url}`);
    response.writeHead(answer ? 200 : 404, {'content-type': 'application/json'});
    response.end(JSON.stringify(answer ?? {kind: 'Status', apiVersion: 'v1', code: 404, status: 'Failure'}));
  });
  return new Promise((resolve) => {
    server.listen(0, '127.0.0.1', () => resolve({server, asked}));
  });
}

const kubectl = spawnSync('kubectl', ['version', '--client'], {encoding: 'utf8'});
test(
  'kubectl takes it, by --dry-run=client',
  {skip: kubectl.error ? 'kubectl is not here: apt install kubernetes-client' : false},
  async () => {
    const {server, asked} = await discovery();
    const home = mkdtempSync(path.join(tmpdir(), 'aprsim-kubectl-'));
    try {
      const address = `http://127.0.0.1:${server.address().port}`;
      const line = ['--server', address, 'create', '--dry-run=client', '--validate=false', '-o', 'json'];
      // Not spawnSync: the server answers in this process.
      const {stdout} = await promisify(execFile)('kubectl', [...line, '-k', folder], {
        env: {...process.env, HOME: home, KUBECONFIG: path.join(home, 'none')},
      });
      const made = JSON.parse(stdout.startsWith('[') ? stdout : `[${stdout.replace(/^}\n{/gm, '},{')}]`);
      const items = made.flatMap((one) => (one.kind === 'List' ? one.items : [one]));
      assert.deepEqual(items.map((one) => one.kind).sort(), [
        ...['ConfigMap', 'Job', 'Job', 'Namespace', 'PersistentVolumeClaim'],
      ]);
      const config = items.find((one) => one.kind === 'ConfigMap');
      const batch = items.find((one) => one.kind === 'Job' && one.metadata.name === 'batch');
      assert.equal(batch.metadata.namespace, 'aprsim');
      assert.equal(batch.spec.template.spec.containers[0].image, 'aprsim:latest');
      // The name has the content's hash in it: another batch, another Job's configuration.
      assert.equal(
        batch.spec.template.spec.containers[0].envFrom[0].configMapRef.name,
        config.metadata.name,
      );
      assert.equal(batch.spec.backoffLimitPerIndex, 5);
      assert.ok(asked.every((one) => one.startsWith('GET ')), 'a dry run changes nothing');
    } finally {
      server.close();
      rmSync(home, {recursive: true});
    }
  },
);
