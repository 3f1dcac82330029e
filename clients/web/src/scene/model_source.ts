// Source of the robots' descriptions: the daemon by default.
type ModelSource = (robot: string) => Promise<string>;

let source: ModelSource = async (robot) => {
  const answer = await fetch(`models/${encodeURIComponent(robot)}.urdf`);
  if (!answer.ok) throw new Error(`no model of ${robot}`);
  return answer.text();
};

export function setModelSource(other: ModelSource): void {
  source = other;
}

/** Description (URDF) of a robot; rejects where there is none. */
export function modelOf(robot: string): Promise<string> {
  return source(robot);
}
