// Fixed parts of the cell: floor, tables, conveyor frame; and the moving texture of the belt.
import * as THREE from 'three';
import type {CellAppearance, ConveyorDescription} from '../protocol';
import {place, toVector} from './convert';
import {painted, solid, surface} from './materials';
import {segments, software} from './quality';
import {merged, softBox, softCylinder, tinted} from './shapes';

const kLegFrom = 0.3; // [m] height from which a wide box gets legs
const kPattern_m = 0.24;

function canvas(
  width: number,
  height: number,
  draw: (c: CanvasRenderingContext2D) => void
): THREE.CanvasTexture {
  const element = document.createElement('canvas');
  element.width = width;
  element.height = height;
  draw(element.getContext('2d')!);
  const texture = new THREE.CanvasTexture(element);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.anisotropy = software ? 1 : 4;
  return texture;
}

/** Floor that fades into the background, with a grid of one metre. */
export function makeFloor(): THREE.Mesh {
  const texture = canvas(256, 256, (c) => {
    c.fillStyle = '#fff';
    c.fillRect(0, 0, 256, 256);
    c.strokeStyle = 'rgba(0,0,0,0.16)';
    c.lineWidth = 2;
    c.strokeRect(0, 0, 256, 256);
    c.strokeStyle = 'rgba(0,0,0,0.05)';
    c.lineWidth = 1;
    for (let i = 64; i < 256; i += 64) {
      c.strokeRect(i, -2, 0, 260);
      c.strokeRect(-2, i, 260, 0);
    }
  });
  texture.repeat.set(24, 24);
  const floor = new THREE.Mesh(
    new THREE.CircleGeometry(12, segments(48)),
    surface({map: texture, roughness: 0.95, metalness: 0})
  );
  floor.receiveShadow = true;
  return floor;
}

function opticalTop(size: THREE.Vector3): THREE.Material {
  const texture = canvas(64, 64, (c) => {
    c.fillStyle = '#c9ced4';
    c.fillRect(0, 0, 64, 64);
    c.fillStyle = '#70777f';
    c.beginPath();
    c.arc(32, 32, 7, 0, 7);
    c.fill();
  });
  texture.repeat.set(size.x / 0.05, size.y / 0.05);
  return surface({map: texture, roughness: 0.35, metalness: 0.45});
}

/** Tables and frames: boxes of the scene, with legs under raised ones. */
export function makeFixed(appearance: CellAppearance): THREE.Group {
  const group = new THREE.Group();
  for (const box of appearance.fixed) {
    const size = toVector(box.sizeM);
    const piece = new THREE.Group();
    place(piece, box.boxInWorld);
    piece.userData.pick = {kind: 'fixed', name: box.name, size};
    const wide = size.x * size.y > 0.25;
    const optical = /optical/.test(box.name);
    const color = optical
      ? 0x3a4048
      : /frame/.test(box.name)
        ? 0x8d97a3
        : wide
          ? 0xd9d4c8
          : 0x7d858f;
    piece.add(
      painted(softBox(size.x, size.y, size.z, 0.008), color, {
        roughness: 0.5,
        metalness: wide ? 0.1 : 0.5
      })
    );
    if (optical) {
      const top = new THREE.Mesh(
        new THREE.PlaneGeometry(size.x - 0.03, size.y - 0.03),
        opticalTop(size)
      );
      top.position.z = size.z / 2 + 4e-4;
      top.receiveShadow = true;
      piece.add(top);
    }
    const below = piece.position.z - size.z / 2;
    if (wide && below > kLegFrom) piece.add(legs(size, below));
    group.add(piece);
  }
  return group;
}

function legs(size: THREE.Vector3, height: number): THREE.Mesh {
  const parts: THREE.BufferGeometry[] = [];
  const x = size.x / 2 - 0.07,
    y = size.y / 2 - 0.07,
    w = 0.06;
  for (const [sx, sy] of [
    [1, 1],
    [1, -1],
    [-1, 1],
    [-1, -1]
  ] as const) {
    parts.push(
      tinted(
        softBox(w, w, height - 0.03, 0.004).translate(
          sx * x,
          sy * y,
          -size.z / 2 - (height - 0.03) / 2
        ),
        0x4a525c
      )
    );
    parts.push(
      tinted(
        softCylinder(0.04, 0.03)
          .rotateX(Math.PI / 2)
          .translate(sx * x, sy * y, -size.z / 2 - height + 0.015),
        0x22262b
      )
    );
  }
  for (const side of [1, -1]) {
    parts.push(
      tinted(
        softBox(2 * x, 0.04, 0.05, 0.004).translate(0, side * y, -size.z / 2 - 0.75 * height),
        0x4a525c
      )
    );
  }
  return solid(merged(parts), surface({vertexColors: true, roughness: 0.5, metalness: 0.4}));
}

/** The belt with its rollers and rails; its texture moves with the belt. */
export class Belt {
  readonly root = new THREE.Group();
  private readonly texture: THREE.CanvasTexture;

  constructor(conveyor: ConveyorDescription) {
    place(this.root, conveyor.beltInWorld);
    this.root.userData.pick = {kind: 'belt'};
    this.texture = canvas(128, 256, (c) => {
      c.fillStyle = '#30363d';
      c.fillRect(0, 0, 128, 256);
      c.fillStyle = '#3a424b';
      for (let x = 0; x < 128; x += 16) c.fillRect(x, 0, 8, 256);
      c.strokeStyle = '#4d5864';
      c.lineWidth = 7;
      c.beginPath();
      c.moveTo(48, 84);
      c.lineTo(80, 128);
      c.lineTo(48, 172);
      c.stroke();
    });
    this.texture.repeat.set(conveyor.lengthM / kPattern_m, 1);
    const {lengthM: l, widthM: w} = conveyor;
    const top = new THREE.Mesh(
      new THREE.PlaneGeometry(l, w),
      surface({map: this.texture, roughness: 0.85, metalness: 0})
    );
    top.receiveShadow = true;
    this.root.add(top);
    const parts: THREE.BufferGeometry[] = [
      tinted(softBox(l, w, 0.02, 0.001).translate(0, 0, -0.0105), 0x2b3036)
    ];
    for (const end of [1, -1]) {
      parts.push(
        tinted(softCylinder(0.045, w - 0.01, 0.003).translate((end * l) / 2, 0, -0.0455), 0x2b3036)
      );
      parts.push(
        tinted(softCylinder(0.016, w + 0.07, 0.003).translate((end * l) / 2, 0, -0.0455), 0xb9c1ca)
      );
    }
    for (const side of [1, -1]) {
      parts.push(
        tinted(
          softBox(l + 0.06, 0.02, 0.05, 0.003).translate(0, side * (w / 2 + 0.013), -0.022),
          0xbcc4cc
        )
      );
    }
    const motor = softBox(0.16, 0.12, 0.12, 0.01).translate(l / 2 - 0.1, -(w / 2 + 0.085), -0.09);
    parts.push(tinted(motor, 0x2f6fb3));
    this.root.add(
      solid(merged(parts), surface({vertexColors: true, roughness: 0.45, metalness: 0.35}))
    );
  }

  update(travel_m: number): void {
    this.texture.offset.x = -((travel_m / kPattern_m) % 1);
  }
}
