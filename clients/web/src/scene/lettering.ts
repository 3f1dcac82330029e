// Printed text on things in the view: nameplates and labels.
import * as THREE from 'three';
import {surface} from './materials';
import {software} from './quality';

export interface Lettering {
  text: string;
  ink: string;
  ground: string;
}

const kHeight_px = 64;

/** A material with one line of text; `aspect` is the width of the surface over its height. */
export function lettered({text, ink, ground}: Lettering, aspect: number): THREE.Material {
  const canvas = document.createElement('canvas');
  canvas.height = kHeight_px;
  canvas.width = Math.round(kHeight_px * aspect);
  const c = canvas.getContext('2d')!;
  c.fillStyle = ground;
  c.fillRect(0, 0, canvas.width, canvas.height);
  c.fillStyle = ink;
  c.font = `600 ${0.72 * kHeight_px}px system-ui, 'DejaVu Sans', sans-serif`;
  c.textAlign = 'center';
  c.textBaseline = 'middle';
  c.fillText(text, canvas.width / 2, 0.54 * canvas.height, 0.94 * canvas.width);
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  map.anisotropy = software ? 2 : 8;
  return surface({map, roughness: 0.5, metalness: 0});
}

/** A flat label, centred on the origin in the x-y plane, that faces +z. */
export function flatLabel(lettering: Lettering, width_m: number, height_m: number): THREE.Mesh {
  const mesh = new THREE.Mesh(
    new THREE.PlaneGeometry(width_m, height_m),
    lettered(lettering, width_m / height_m)
  );
  mesh.receiveShadow = true;
  return mesh;
}
