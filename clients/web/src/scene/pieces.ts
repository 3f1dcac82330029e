// Parts and fixtures of convex pieces.
import * as THREE from 'three';
import {ConvexGeometry} from 'three/examples/jsm/geometries/ConvexGeometry.js';
import type {FixtureDescription, Piece} from '../protocol';
import {place, toMatrix, toVector} from './convert';
import {surface} from './materials';
import {segments} from './quality';
import {merged, tinted} from './shapes';

const kSides = 40;
const kFixture = 0x7d8793;

function shapeOf(piece: Piece): THREE.BufferGeometry {
  const {shape} = piece;
  switch (shape.case) {
    case 'box': {
      const size = toVector(shape.value.sizeM);
      return new THREE.BoxGeometry(size.x, size.y, size.z);
    }
    case 'cone': {
      const {topRadiusM, bottomRadiusM, heightM} = shape.value;
      return new THREE.CylinderGeometry(
        topRadiusM,
        bottomRadiusM,
        heightM,
        segments(kSides)
      ).rotateX(Math.PI / 2);
    }
    case 'capsule': {
      const {radiusM, lengthM} = shape.value,
        sides = segments(kSides);
      return lengthM > 0
        ? new THREE.CapsuleGeometry(radiusM, lengthM, Math.ceil(sides / 4), sides).rotateX(
            Math.PI / 2
          )
        : new THREE.SphereGeometry(radiusM, sides, Math.ceil(sides / 2));
    }
    case 'prism': {
      const {cornersM, heightM} = shape.value;
      const outline = new THREE.Shape(cornersM.map((p) => new THREE.Vector2(p.x, p.y)));
      return new THREE.ExtrudeGeometry(outline, {depth: heightM, bevelEnabled: false}).translate(
        0,
        0,
        -heightM / 2
      );
    }
    case 'hull':
      return new ConvexGeometry(shape.value.cornersM.map((p) => toVector(p)));
    default:
      return new THREE.BoxGeometry(0.01, 0.01, 0.01);
  }
}

/** All pieces in the frame of their part or fixture. */
export function piecesGeometry(
  pieces: Piece[],
  color: THREE.ColorRepresentation
): THREE.BufferGeometry {
  return merged(
    pieces.map((piece) => tinted(shapeOf(piece), color).applyMatrix4(toMatrix(piece.pieceInBody)))
  );
}

/** A fixture as one object to select. */
export function makeFixture(fixture: FixtureDescription): THREE.Mesh {
  const mesh = new THREE.Mesh(
    piecesGeometry(fixture.pieces, kFixture),
    surface({vertexColors: true, roughness: 0.5, metalness: 0.3})
  );
  mesh.castShadow = mesh.receiveShadow = true;
  place(mesh, fixture.fixtureInWorld);
  mesh.userData.pick = {kind: 'fixed', name: fixture.name};
  return mesh;
}
