import * as THREE from 'three';
import {
  BodyKind,
  GroupKind,
  type BodyDescription,
  type BodyState,
  type CellDescription,
  type CellAppearance,
  type TrayGeometry
} from '../protocol';
import {place, toMatrix, toVector} from './convert';
import {surface, type SurfaceMaterial} from './materials';
import {flatLabel} from './lettering';
import {piecesGeometry} from './pieces';
import {gearGeometry, trayGeometry, type Pocket, type Slab} from './shapes';

const kGearColors = [0xf08a24, 0x18a999, 0x8a63d2, 0xd64550, 0x3f8efc];
const kPartColors = [0x3f7fd0, 0xc8ccd2, 0xb5533c, 0xd9a441, 0x5b8f6b, 0x7a5ea8, 0x4a5058];
const kGroupNames: Record<number, string> = {
  [GroupKind.JOINED]: 'joined, group',
  [GroupKind.MERGED]: 'merged, group',
  [GroupKind.DORMANT]: 'dormant, group'
};
const kPartTray = 0xc9cfd6,
  kKitTray = 0x38495e;

/** Sizes of a tray's label [m], the largest first. */
const kLabelSizes = [
  [0.07, 0.012],
  [0.055, 0.01],
  [0.045, 0.008],
  [0.035, 0.0065]
] as const;
const kLabelStep_m = 0.003;
const kLabelMargin_m = 0.0015;

/** Gears, trays and parts. Bodies of one type share one geometry. */
export class Parts {
  readonly root = new THREE.Group();
  readonly meshes: THREE.Mesh[] = [];
  private readonly plain = surface({vertexColors: true, roughness: 0.55, metalness: 0.02});
  private readonly grouped = new Map<string, SurfaceMaterial>();

  constructor(cell: CellDescription, appearance: CellAppearance | null) {
    const shapes = new Map<string, THREE.BufferGeometry>();
    const gears = [
      ...new Set(cell.bodies.filter((b) => b.kind === BodyKind.GEAR).map((b) => b.type))
    ];
    const types = cell.bodyTypes.filter((type) =>
      cell.bodies.some((b) => b.type === type && b.kind === BodyKind.PART)
    );
    const sizes = new Map(
      cell.bodies.map((b) => [
        b.type,
        b.geometry.case === 'gear' ? b.geometry.value.discRadiusM : 0
      ])
    );
    gears.sort((a, b) => sizes.get(b)! - sizes.get(a)!);
    cell.bodies.forEach((body, index) => {
      let shape = shapes.get(body.type);
      if (!shape)
        shapes.set(
          body.type,
          (shape = geometryOf(
            body,
            appearance,
            body.kind === BodyKind.PART ? types.indexOf(body.type) : gears.indexOf(body.type)
          ))
        );
      const mesh = new THREE.Mesh(shape, this.plain);
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.userData.pick = {kind: 'body', index};
      const label = trayLabel(body, appearance);
      if (label) mesh.add(label);
      this.meshes.push(mesh);
      this.root.add(mesh);
    });
  }

  update(bodies: BodyState[], showGroups: boolean): void {
    bodies.forEach((body, i) => {
      const mesh = this.meshes[i];
      if (!mesh) return;
      place(mesh, body.bodyInWorld);
      mesh.material = showGroups ? this.groupMaterial(body) : this.plain;
    });
  }

  private groupMaterial(body: BodyState): THREE.Material {
    if (body.group === undefined) return this.plain;
    const key = groupOf(body);
    let material = this.grouped.get(key);
    if (!material) {
      const hue = ((body.group + 1) * 0.618034) % 1; // neighbouring numbers far apart
      material = surface({
        color: new THREE.Color().setHSL(hue, 0.62, 0.55),
        roughness: 0.6,
        metalness: 0
      });
      this.grouped.set(key, material);
    }
    return material;
  }
}

/** Which simplified group a body belongs to; empty when none. */
export function groupOf(body: BodyState): string {
  if (body.group !== undefined) return `${kGroupNames[body.groupKind] ?? 'grouped'} ${body.group}`;
  return body.resting ? 'at rest' : '';
}

function geometryOf(
  body: BodyDescription,
  appearance: CellAppearance | null,
  number: number
): THREE.BufferGeometry {
  const {geometry} = body;
  if (geometry.case === 'part')
    return piecesGeometry(
      geometry.value.pieces,
      kPartColors[Math.max(0, number) % kPartColors.length]!
    );
  if (geometry.case === 'gear') {
    const {discRadiusM, discHeightM, pegRadiusM, pegTopM} = geometry.value;
    const {
      hubTopRadiusM = 0,
      hubBottomRadiusM = 0,
      hubHeightM = 0,
      teethRadiusM = 0
    } = appearance?.gears.find((g) => g.type === body.type) ?? {};
    const sizes = {
      discRadiusM,
      discHeightM,
      pegRadiusM,
      pegTopM,
      hubTopRadiusM,
      hubBottomRadiusM,
      hubHeightM,
      teethRadiusM
    };
    return gearGeometry(
      sizes,
      new THREE.Color(kGearColors[Math.max(0, number) % kGearColors.length])
    );
  }
  if (geometry.case !== 'tray') return new THREE.BoxGeometry(0.02, 0.02, 0.02);
  const tray = geometry.value;
  const pockets = pocketsOf(body, appearance);
  const color = new THREE.Color(body.kind === BodyKind.KIT_TRAY ? kKitTray : kPartTray);
  return trayGeometry(slabOf(tray), pockets, color);
}

function slabOf(tray: TrayGeometry): Slab {
  return {
    min: toVector(tray.boxMinM),
    max: toVector(tray.boxMaxM),
    outline: tray.outlineM.map((p) => new THREE.Vector2(p.x, p.y)),
    labelSize: tray.labelSizeM,
    labelDepth: tray.labelDepthM
  };
}

function pocketsOf(body: BodyDescription, appearance: CellAppearance | null): Pocket[] {
  if (body.geometry.case !== 'tray') return [];
  const recesses = appearance?.trays.find((t) => t.type === body.type)?.pockets ?? [];
  return body.geometry.value.slots.flatMap((slot, i) => {
    const p = toVector(slot.slotInTray?.positionM),
      recess = recesses[i];
    if (!recess) return [];
    const frame = toMatrix(slot.slotInTray);
    const corners = slot.pocketOutlineM.map((corner) => toVector(corner).applyMatrix4(frame));
    const outline = corners.map((corner) => new THREE.Vector2(corner.x, corner.y));
    // A circle around, where it matters which places are free.
    const around = outline.map((corner) => Math.hypot(corner.x - p.x, corner.y - p.y));
    const top = Math.max(recess.topRadiusM, ...around);
    return [{x: p.x, y: p.y, top, floor: recess.floorRadiusM, depth: recess.depthM, outline}];
  });
}

/** A label with the tray's name on its top, where no pocket is; null where there is no room. */
function trayLabel(body: BodyDescription, appearance: CellAppearance | null): THREE.Mesh | null {
  if (body.geometry.case !== 'tray') return null;
  const slab = slabOf(body.geometry.value);
  const place = labelPlace(slab, pocketsOf(body, appearance));
  if (!place) return null;
  const kit = body.kind === BodyKind.KIT_TRAY;
  const label = flatLabel(
    {
      text: body.name.replaceAll('_', ' '),
      ink: '#15181c',
      ground: kit ? '#e9edf2' : '#f7d774'
    },
    place.width,
    place.height
  );
  label.position.set(place.x, place.y, slab.max.z + 3e-4);
  if (place.turned) label.rotation.z = Math.PI / 2;
  return label;
}

/** Whether a rectangle of half sizes w and h about (x, y) lies within a convex outline. */
function liesWithin(outline: THREE.Vector2[], x: number, y: number, w: number, h: number): boolean {
  return outline.every((a, i) => {
    const b = outline[(i + 1) % outline.length] ?? a;
    const side = b.clone().sub(a);
    // The rectangle's corner that lies farthest to the right of the side.
    const reach = Math.abs(side.y) * w + Math.abs(side.x) * h;
    return side.x * (y - a.y) - side.y * (x - a.x) >= reach;
  });
}

interface LabelPlace {
  x: number;
  y: number;
  width: number;
  height: number;
  turned: boolean;
}

/** The largest label that fits between the pockets, nearest to the tray's lower edge. */
function labelPlace(slab: Slab, pockets: Pocket[]): LabelPlace | null {
  const {min, max, outline, labelSize} = slab;
  for (const [width, height] of kLabelSizes) {
    for (const turned of [false, true]) {
      const w = (turned ? height : width) / 2 + kLabelMargin_m,
        h = (turned ? width : height) / 2 + kLabelMargin_m;
      const isFree = (x: number, y: number): boolean =>
        (labelSize === 0 || Math.abs(x) > w + labelSize / 2 || Math.abs(y) > h + labelSize / 2) &&
        liesWithin(outline, x, y, w, h) &&
        pockets.every(
          (p) =>
            Math.hypot(Math.max(0, Math.abs(p.x - x) - w), Math.max(0, Math.abs(p.y - y) - h)) >
            p.top
        );
      for (let y = min.y + h; y <= max.y - h; y += kLabelStep_m) {
        for (let x = min.x + w; x <= max.x - w; x += kLabelStep_m)
          if (isFree(x, y)) return {x, y, width, height, turned};
      }
    }
  }
  return null;
}
