// All values of a snapshot that can be charted.
import type {CellDescription, Snapshot} from '../protocol';

export interface ChartSignal {
  name: string;
  unit: string;
  read: (s: Snapshot) => number;
}

const kDegrees = 180 / Math.PI;

export function signalsOf(cell: CellDescription): ChartSignal[] {
  const all: ChartSignal[] = [
    {name: 'real-time factor', unit: '', read: (s) => s.realTimeFactor},
    {
      name: 'step time',
      unit: 'µs',
      read: (s) => Number(s.stepTime?.seconds ?? 0) * 1e6 + (s.stepTime?.nanos ?? 0) / 1e3
    },
    {name: 'contacts', unit: '', read: (s) => s.contactCount},
    {name: 'virtual joints', unit: '', read: (s) => s.virtualJointCount},
    {name: 'deepest contact', unit: 'mm', read: (s) => s.maxPenetrationM * 1e3}
  ];
  cell.robots.forEach((robot, r) => {
    robot.joints.forEach((joint, j) => {
      const name = `${robot.name} J${j + 1}`;
      const [unit, scale] = joint.prismatic ? ['mm', 1e3] : ['°', kDegrees];
      all.push(
        {
          name: `${name} position`,
          unit,
          read: (s) => (s.robots[r]?.joints[j]?.positionRad ?? NaN) * scale
        },
        {
          name: `${name} velocity`,
          unit: `${unit}/s`,
          read: (s) => (s.robots[r]?.joints[j]?.velocityRadS ?? NaN) * scale
        },
        {
          name: `${name} ${joint.prismatic ? 'force' : 'torque'}`,
          unit: joint.prismatic ? 'N' : 'Nm',
          read: (s) => s.robots[r]?.joints[j]?.torqueNm ?? NaN
        }
      );
    });
    for (const axis of ['x', 'y', 'z'] as const) {
      all.push(
        {
          name: `${robot.name} tool ${axis}`,
          unit: 'mm',
          read: (s) => (s.robots[r]?.toolInReference?.positionM?.[axis] ?? NaN) * 1e3
        },
        {
          name: `${robot.name} tool force ${axis}`,
          unit: 'N',
          read: (s) => s.robots[r]?.toolForceN?.[axis] ?? NaN
        }
      );
    }
    all.push(
      {
        name: `${robot.name} tool speed`,
        unit: 'mm/s',
        read: (s) => {
          const v = s.robots[r]?.toolVelocityMS;
          return v ? Math.hypot(v.x, v.y, v.z) * 1e3 : NaN;
        }
      },
      {
        name: `${robot.name} gripper separation`,
        unit: 'mm',
        read: (s) => (s.robots[r]?.gripper?.separationM ?? NaN) * 1e3
      },
      {
        name: `${robot.name} gripper force 1`,
        unit: 'N',
        read: (s) => s.robots[r]?.gripper?.forceN[0] ?? NaN
      },
      {
        name: `${robot.name} gripper force 2`,
        unit: 'N',
        read: (s) => s.robots[r]?.gripper?.forceN[1] ?? NaN
      }
    );
  });
  if (cell.conveyor) {
    all.push(
      {name: 'belt speed', unit: 'mm/s', read: (s) => (s.conveyor?.speedMS ?? NaN) * 1e3},
      {name: 'belt travel', unit: 'mm', read: (s) => (s.conveyor?.travelM ?? NaN) * 1e3},
      {name: 'belt motor current', unit: 'A', read: (s) => s.conveyor?.motorCurrentA ?? NaN},
      {name: 'belt load', unit: 'kg', read: (s) => s.conveyor?.loadKg ?? NaN}
    );
  }
  cell.bodies.forEach((body, b) => {
    for (const axis of ['x', 'y', 'z'] as const) {
      all.push({
        name: `${body.name} ${axis}`,
        unit: 'mm',
        read: (s) => (s.bodies[b]?.bodyInWorld?.positionM?.[axis] ?? NaN) * 1e3
      });
    }
  });
  return all;
}
