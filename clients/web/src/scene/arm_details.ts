// Details of the arms beyond the shapes of their URDF: bolts, hoses, cable glands, nameplates. All
// shapes are simple ones of ours, placed by hand after the makers' drawings.
import * as THREE from 'three';
import {flatLabel} from './lettering';
import {segments} from './quality';
import {softBox, tinted} from './shapes';

type Point = [number, number, number];

interface Hose {
  radius: number;
  points: Point[];
}
interface Plate {
  text: string;
  ink: string;
  ground: string;
  at: Point;
  /** Roll, pitch, yaw from a plate that faces +z and reads along +x. */
  rpy: Point;
  size: [number, number];
}
/** Details of one link, in its frame [m]. */
interface LinkDetails {
  hoses?: Hose[];
  plates?: Plate[];
}

const kHoseColor = 0x17191c,
  kClampColor = 0x9aa2ab,
  kBoltColor = 0x8b929a;
const kSilver = {ink: '#20242a', ground: '#c9ced4'};
const kYellow = {ink: '#16181b', ground: '#f2c21c'};
const kRightAngle = Math.PI / 2;

/** Details, keyed by the model's name in its URDF and by link. */
const kDetails: Record<string, Record<string, LinkDetails>> = {
  fanuc_lrmate200id: {
    base_link: {
      hoses: [-0.03, 0.03].map((y) => ({
        radius: 0.008,
        points: [
          [-0.1, y, 0.06],
          [-0.15, y, 0.058],
          [-0.172, y, 0.03],
          [-0.175, y, -0.02]
        ]
      })),
      plates: [
        {
          ...kSilver,
          text: '200iD',
          at: [0.0822, 0, 0.05],
          rpy: [kRightAngle, 0, kRightAngle],
          size: [0.06, 0.018]
        }
      ]
    },
    link_2: {
      hoses: [
        {
          radius: 0.007,
          points: [
            [-0.06, 0.055, 0.04],
            [-0.085, 0.06, 0.12],
            [-0.082, 0.058, 0.24],
            [-0.055, 0.05, 0.31]
          ]
        }
      ]
    },
    link_3: {
      plates: [1, -1].map((side) => ({
        ...kYellow,
        text: 'LR Mate 200iD',
        at: [0.007, side * 0.0604, 0.045],
        rpy: [kRightAngle, 0, side > 0 ? Math.PI : 0],
        size: [0.12, 0.022]
      }))
    },
    link_4: {
      hoses: [
        {
          radius: 0.006,
          points: [
            [0.1, 0.02, 0.06],
            [0.15, 0.04, 0.085],
            [0.23, 0.05, 0.07],
            [0.285, 0.046, 0.035]
          ]
        }
      ]
    }
  },
  motoman_sia20: {
    base_link: {
      hoses: [-0.04, 0, 0.04].map((y) => ({
        radius: 0.011,
        points: [
          [-0.198, y, 0.1],
          [-0.25, y, 0.095],
          [-0.275, y, 0.05],
          [-0.28, y, -0.03]
        ]
      })),
      plates: [
        {
          ...kSilver,
          text: 'SIA20',
          at: [-0.145, -0.1004, 0.06],
          rpy: [kRightAngle, 0, 0],
          size: [0.08, 0.026]
        }
      ]
    },
    link_l: {
      hoses: [
        {
          radius: 0.009,
          points: [
            [0.06, 0.06, 0.07],
            [0.085, 0.075, 0.13],
            [0.085, 0.07, 0.21],
            [0.06, 0.055, 0.255]
          ]
        }
      ],
      plates: [1, -1].map((side) => ({
        text: 'MOTOMAN',
        ink: '#f2f5f8',
        ground: '#0d3d9e',
        at: [side * 0.0859, -0.065, 0.09],
        rpy: [kRightAngle, 0, side * kRightAngle],
        size: [0.066, 0.02]
      }))
    },
    link_u: {
      hoses: [
        {
          radius: 0.008,
          points: [
            [0.045, -0.045, 0.06],
            [0.065, -0.058, 0.12],
            [0.062, -0.055, 0.19],
            [0.045, -0.042, 0.235]
          ]
        }
      ]
    }
  }
};

/** Hoses with a clamp at either end, for one link. */
export function hosesOf(model: string, link: string): THREE.BufferGeometry[] {
  const parts: THREE.BufferGeometry[] = [];
  for (const {radius, points} of kDetails[model]?.[link]?.hoses ?? []) {
    const curve = new THREE.CatmullRomCurve3(points.map((p) => new THREE.Vector3(...p)));
    parts.push(
      tinted(new THREE.TubeGeometry(curve, segments(20), radius, segments(10)), kHoseColor)
    );
    for (const t of [0.04, 0.96]) {
      const clamp = softBox(2.8 * radius, 2.8 * radius, 1.6 * radius, 0.002);
      clamp.applyQuaternion(
        new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), curve.getTangent(t))
      );
      parts.push(tinted(clamp.translate(...curve.getPoint(t).toArray()), kClampColor));
    }
  }
  return parts;
}

export function platesOf(model: string, link: string): THREE.Mesh[] {
  return (kDetails[model]?.[link]?.plates ?? []).map(({at, rpy, size, ...lettering}) => {
    const plate = flatLabel(lettering, ...size);
    plate.position.set(...at);
    plate.rotation.set(...rpy, 'ZYX');
    return plate;
  });
}

/** Bolt heads around both faces of a round cover, which lies about y like the cylinders of three.js. */
export function boltsOf(part: string, radius: number, length: number): THREE.BufferGeometry[] {
  if (!/cap|foot|flange_disc/.test(part)) return [];
  const count = radius > 0.1 ? 12 : radius > 0.04 ? 8 : 6;
  const size = Math.min(0.007, 0.1 * radius);
  const bolts: THREE.BufferGeometry[] = [];
  for (let i = 0; i < count; ++i) {
    const angle = (2 * Math.PI * i) / count;
    const bolt = new THREE.CylinderGeometry(size, size, length + 0.9 * size, 6);
    bolts.push(
      tinted(
        bolt.translate(0.82 * radius * Math.cos(angle), 0, 0.82 * radius * Math.sin(angle)),
        kBoltColor
      )
    );
  }
  return bolts;
}
