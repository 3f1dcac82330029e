// Where the robots' descriptions come from: the daemon, unless told otherwise.
type ModelSource = (robot: string) => Promise<string>;

let source: ModelSource = async (robot) => {
  const answer = await fetch(`models/${encodeURIComponent(robot)}.urdf`);
  if (!answer.ok) throw new Error(`no model of ${robot}`);
  return answer.text();
};

export function setModelSource(other: ModelSource): void {
  source = other;
}

/** The description (URDF) of the robot with this name; rejects when there is none. */
export function modelOf(robot: string): Promise<string> {
  return source(robot);
}
