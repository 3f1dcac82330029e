// Quality of drawing. Without a graphics processor every pixel, corner and shader costs.

export let isWebGlAvailable = true;

/** A context of a software driver, which is kept since making one takes long there; null on others. */
function softwareContext(whatever: boolean): WebGL2RenderingContext | null {
  const canvas = document.createElement('canvas');
  // Resizing a canvas that has a context would take as long again.
  canvas.width = canvas.height = 16;
  const gl = canvas.getContext('webgl2', {antialias: false, alpha: false, stencil: false});
  isWebGlAvailable = gl !== null;
  if (!gl) return null;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  if (whatever || /swiftshader|llvmpipe|software|basic render/i.test(name)) return gl;
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return null;
}

// "?quality=fine" draws finely whatever it takes, "?quality=quick" coarsely on any machine.
const wanted = new URLSearchParams(location.search).get('quality');
export const context = wanted === 'fine' ? null : softwareContext(wanted === 'quick');
export const software = context !== null;
export const adaptive = wanted !== 'fine';

/** Number of segments, reduced where each one costs time. */
export function segments(fine: number): number {
  return software ? Math.max(8, Math.round(0.6 * fine)) : fine;
}
