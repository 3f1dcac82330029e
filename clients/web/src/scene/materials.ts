// Surfaces. Without a graphics processor every pixel costs, so surfaces are simpler there.
import * as THREE from 'three';

/** A context whose driver turns out to be software; contexts take long to make there, so it is kept. */
function softwareContext(whatever: boolean): WebGL2RenderingContext | null {
  const gl = document.createElement('canvas').getContext('webgl2', {antialias: false});
  if (!gl) return null;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  if (whatever || /swiftshader|llvmpipe|software|basic render/i.test(name)) return gl;
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return null;
}

// "?quality=fine" draws finely whatever it takes, "?quality=quick" coarsely on any machine.
const quality = new URLSearchParams(location.search).get('quality');
const context = quality === 'fine' ? null : softwareContext(quality === 'quick');
export const software = context !== null;

export function makeRenderer(): THREE.WebGLRenderer {
  if (!context) return new THREE.WebGLRenderer({antialias: true, powerPreference: 'high-performance'});
  return new THREE.WebGLRenderer({canvas: context.canvas, context, antialias: false});
}

export interface Surface {
  color?: THREE.ColorRepresentation;
  map?: THREE.Texture;
  vertexColors?: boolean;
  roughness: number;
  metalness: number;
}

export type SurfaceMaterial = THREE.MeshStandardMaterial | THREE.MeshLambertMaterial;

export function surface({roughness, metalness, ...rest}: Surface): SurfaceMaterial {
  return software ? new THREE.MeshLambertMaterial(rest) : new THREE.MeshStandardMaterial({roughness, metalness, ...rest});
}
