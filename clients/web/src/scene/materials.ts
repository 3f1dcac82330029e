// Surfaces. In software they are simpler, and share one material: each program takes long to compile.
import * as THREE from 'three';
import {context, software} from './quality';
import {tinted} from './shapes';

export function makeRenderer(): THREE.WebGLRenderer {
  if (!context)
    return new THREE.WebGLRenderer({antialias: true, powerPreference: 'high-performance'});
  return new THREE.WebGLRenderer({
    canvas: context.canvas,
    context,
    antialias: false,
    alpha: false,
    stencil: false
  });
}

export interface Finish {
  roughness: number;
  metalness: number;
}
export interface Surface extends Finish {
  color?: THREE.ColorRepresentation;
  map?: THREE.Texture;
  vertexColors?: boolean;
}
export type SurfaceMaterial = THREE.MeshStandardMaterial | THREE.MeshLambertMaterial;

const common = new THREE.MeshLambertMaterial({vertexColors: true});

export function surface({roughness, metalness, ...rest}: Surface): SurfaceMaterial {
  if (!software) return new THREE.MeshStandardMaterial({roughness, metalness, ...rest});
  return rest.vertexColors ? common : new THREE.MeshLambertMaterial(rest);
}

/** A mesh of one colour that casts and receives shadows. */
export function painted(
  geometry: THREE.BufferGeometry,
  color: THREE.ColorRepresentation,
  finish: Finish
): THREE.Mesh {
  return solid(tinted(geometry, color), surface({vertexColors: true, ...finish}));
}

export function solid(geometry: THREE.BufferGeometry, material: THREE.Material): THREE.Mesh {
  const mesh = new THREE.Mesh(geometry, material);
  mesh.castShadow = mesh.receiveShadow = true;
  return mesh;
}

const kGlow = {fault: new THREE.Color(0xff1f14), 'drives off': new THREE.Color(0xffa000)};
/** The same surface, glowing, for a robot that is stopped. */
export function stoppedSurface(plain: THREE.Material, stopped: keyof typeof kGlow): THREE.Material {
  const material = plain.clone() as SurfaceMaterial;
  material.emissive = kGlow[stopped];
  material.emissiveIntensity = stopped === 'fault' ? 0.5 : 0.28;
  return material;
}
