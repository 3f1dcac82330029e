// A scene in npm's jolt-physics: Jolt compiled to WebAssembly, in single precision.
// usage: node jolt_wasm.mjs MODEL; jolt_process.hpp says what it is asked and answers.
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {createInterface} from 'node:readline';
import initJolt from 'jolt-physics';

const FIXED = 0;
const FREE = 1;
const WARM_UP = 300; // steps, until everything is compiled

const Jolt = await initJolt();
const model = JSON.parse(readFileSync(process.argv[2], 'utf8'));
const {version} = createRequire(import.meta.url)('jolt-physics/package.json');

const vector = ([x, y, z]) => new Jolt.Vec3(x, y, z);

function created(settings) {
  const result = settings.Create();
  if (result.HasError()) throw new Error(result.GetError().c_str());
  return result.Get();
}

/** A cone or a cylinder about z; Jolt's are about y. */
function roundShape(part, margin) {
  const {half_height: half, low_radius: low, high_radius: high} = part;
  return low === high
    ? new Jolt.CylinderShapeSettings(half, low, margin)
    : new Jolt.TaperedCylinderShapeSettings(half, high, low, margin);
}

function shapeOf(parts, margin) {
  if (parts.length === 1) return created(new Jolt.BoxShapeSettings(vector(parts[0].half), margin));
  const upright = Jolt.Quat.prototype.sRotation(new Jolt.Vec3(1, 0, 0), Math.PI / 2);
  const turn = new Jolt.Quat(upright.GetX(), upright.GetY(), upright.GetZ(), upright.GetW());
  const compound = new Jolt.StaticCompoundShapeSettings();
  for (const part of parts) {
    const flat = 'half' in part;
    const shape = flat
      ? new Jolt.BoxShapeSettings(vector(part.half), margin)
      : roundShape(part, margin);
    compound.AddShapeShapeSettings(
      vector(part.at),
      flat ? new Jolt.Quat(0, 0, 0, 1) : turn,
      shape,
      0
    );
  }
  // The shapes' own density says another centre of mass than the scene.
  const com = created(compound).GetCenterOfMass();
  const offset = new Jolt.Vec3(-com.GetX(), -com.GetY(), -com.GetZ());
  return created(new Jolt.OffsetCenterOfMassShapeSettings(offset, compound));
}

class Simulation {
  constructor() {
    const settings = new Jolt.JoltSettings();
    const pairs = new Jolt.ObjectLayerPairFilterTable(2);
    pairs.EnableCollision(FIXED, FREE);
    pairs.EnableCollision(FREE, FREE);
    const broad = new Jolt.BroadPhaseLayerInterfaceTable(2, 2);
    for (const layer of [FIXED, FREE]) {
      broad.MapObjectToBroadPhaseLayer(layer, new Jolt.BroadPhaseLayer(layer));
    }
    settings.mObjectLayerPairFilter = pairs;
    settings.mBroadPhaseLayerInterface = broad;
    settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(
      broad,
      2,
      pairs,
      2
    );
    settings.mMaxWorkerThreads = 0;
    settings.mMaxBodies = 1024;
    settings.mMaxBodyPairs = settings.mMaxContactConstraints = 16384;
    this.jolt = new Jolt.JoltInterface(settings);
    this.system = this.jolt.GetPhysicsSystem();
    this.system.SetGravity(new Jolt.Vec3(0, 0, -model.gravity));
    const physics = this.system.GetPhysicsSettings();
    for (const [name, value] of Object.entries(model.settings)) {
      if (!(name in physics)) throw new Error(`this Jolt has no ${name}`);
      physics[name] = value;
    }
    // Bodies on a belt would fall asleep.
    physics.mAllowSleeping = false;
    this.system.SetPhysicsSettings(physics);
    this.bodies = model.bodies.map((body) => this.add(body));
    this.belt = this.bodies[model.bodies.findIndex(({motion}) => motion === 'belt')];
    this.speed = new Jolt.Vec3(0, 0, 0);
  }

  add({motion, surface, p, q, mass, inertia, shapes}) {
    const free = motion === 'free';
    const kind = {
      free: Jolt.EMotionType_Dynamic,
      belt: Jolt.EMotionType_Kinematic,
      fixed: Jolt.EMotionType_Static
    }[motion];
    const settings = new Jolt.BodyCreationSettings(
      shapeOf(shapes, model.convex_radius),
      new Jolt.RVec3(...p),
      new Jolt.Quat(q[1], q[2], q[3], q[0]),
      kind,
      free ? FREE : FIXED
    );
    settings.mFriction = model.friction[surface];
    settings.mRestitution = 0;
    settings.mLinearDamping = settings.mAngularDamping = 0;
    settings.mApplyGyroscopicForce = true;
    settings.mAllowSleeping = false;
    if (free) {
      settings.mOverrideMassProperties = Jolt.EOverrideMassProperties_MassAndInertiaProvided;
      settings.mMassPropertiesOverride.mMass = mass;
      settings.mMassPropertiesOverride.mInertia = Jolt.Mat44.prototype.sScaleVec3(vector(inertia));
    }
    const bodies = this.system.GetBodyInterface();
    const body = bodies.CreateBody(settings);
    bodies.AddBody(body.GetID(), Jolt.EActivation_Activate);
    return body;
  }

  step(speed) {
    if (this.belt) {
      this.speed.Set(speed, 0, 0);
      this.belt.SetLinearVelocity(this.speed);
    }
    this.jolt.Step(model.step_s, 1);
  }

  /** Times of the steps but the last, and the contacts at that one. */
  run(speeds) {
    const us = speeds.slice(0, -1).map((speed) => {
      const start = process.cpuUsage();
      this.step(speed);
      const {user, system} = process.cpuUsage(start);
      return user + system;
    });
    Object.assign(looked, {contacts: 0, deepest_m: 0});
    this.system.SetContactListener(looker);
    this.step(speeds.at(-1));
    this.system.SetContactListener(null);
    return {us, ...looked};
  }

  poses() {
    return this.bodies.map((body) => {
      const p = body.GetCenterOfMassPosition();
      const at = [p.GetX(), p.GetY(), p.GetZ()];
      const q = body.GetRotation();
      return [...at, q.GetW(), q.GetX(), q.GetY(), q.GetZ()];
    });
  }
}

const looked = {contacts: 0, deepest_m: 0};
function take(address) {
  const manifold = Jolt.wrapPointer(address, Jolt.ContactManifold);
  looked.contacts += manifold.mRelativeContactPointsOn1.size();
  looked.deepest_m = Math.max(looked.deepest_m, manifold.mPenetrationDepth);
}
const looker = new Jolt.ContactListenerJS();
looker.OnContactValidate = () => Jolt.ValidateResult_AcceptAllContactsForThisBodyPair;
looker.OnContactAdded = looker.OnContactPersisted = (_a, _b, manifold) => take(manifold);
looker.OnContactRemoved = () => {};

const warm = new Simulation();
for (let i = 0; i < WARM_UP; ++i) warm.step(0.1 * Math.sin(0.1 * i));
Jolt.destroy(warm.jolt);

const simulation = new Simulation();
const say = (answer) => process.stdout.write(`${JSON.stringify(answer)}\n`);
say({version: `${version}, single precision`});
for await (const line of createInterface({input: process.stdin})) {
  const speeds = JSON.parse(line);
  say(speeds.length > 0 ? simulation.run(speeds) : {poses: simulation.poses()});
}
