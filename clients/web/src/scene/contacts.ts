// Contact points and the forces that they bear.
import * as THREE from 'three';
import type {Contact, Snapshot} from '../protocol';
import {toVector} from './convert';

const kMost = 256;
const kDot_m = 0.0028;
const kUp = new THREE.Vector3(0, 1, 0);

/** Length of a force's arrow: forces of the cell span from hundredths to hundreds of newtons. */
function lengthOf(force_N: number): number {
  return 0.032 * Math.log10(1 + force_N / 0.1);
}

function instances(geometry: THREE.BufferGeometry): THREE.InstancedMesh {
  const mesh = new THREE.InstancedMesh(
    geometry,
    new THREE.MeshBasicMaterial({depthTest: false, transparent: true, opacity: 0.95}),
    kMost
  );
  mesh.count = 0;
  mesh.frustumCulled = false;
  mesh.renderOrder = 10;
  return mesh;
}

/** Dots where things touch, arrows along the forces; those of robots in another colour. */
export class Contacts {
  readonly root = new THREE.Group();
  private readonly dots = instances(new THREE.SphereGeometry(kDot_m, 10, 8));
  private readonly shafts = instances(
    new THREE.CylinderGeometry(0.0009, 0.0009, 1, 6).translate(0, 0.5, 0)
  );
  private readonly heads = instances(new THREE.ConeGeometry(0.0032, 0.009, 8));
  private readonly rest = new THREE.Color(0x35d0ff);
  private readonly robot = new THREE.Color(0xff5fa2);

  constructor() {
    this.root.add(this.dots, this.shafts, this.heads);
  }

  update(snapshot: Snapshot): void {
    const contacts = snapshot.contacts.slice(0, kMost);
    const at = new THREE.Vector3(),
      force = new THREE.Vector3(),
      turn = new THREE.Quaternion();
    const one = new THREE.Vector3(1, 1, 1),
      matrix = new THREE.Matrix4(),
      stretch = new THREE.Vector3();
    contacts.forEach((contact, i) => {
      toVector(contact.pointM, at);
      toVector(contact.forceN, force);
      const length = lengthOf(force.length());
      turn.setFromUnitVectors(kUp, force.lengthSq() > 0 ? force.normalize() : kUp);
      this.dots.setMatrixAt(i, matrix.compose(at, turn, one));
      this.shafts.setMatrixAt(
        i,
        matrix.compose(at, turn, stretch.set(1, Math.max(length, 1e-6), 1))
      );
      this.heads.setMatrixAt(
        i,
        matrix.compose(
          at.addScaledVector(force, length),
          turn,
          length > 0.004 ? one : stretch.setScalar(0.3)
        )
      );
      for (const mesh of this.all) mesh.setColorAt(i, ofRobot(contact) ? this.robot : this.rest);
    });
    for (const mesh of this.all) {
      mesh.count = contacts.length;
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }

  private get all(): THREE.InstancedMesh[] {
    return [this.dots, this.shafts, this.heads];
  }
}

function ofRobot(contact: Contact): boolean {
  return contact.first?.thing.case === 'robot' || contact.second?.thing.case === 'robot';
}
