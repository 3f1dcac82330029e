// Source of the robots' descriptions: the daemon by default.
type ModelSource = (robot: string) => Promise<string>;

let source: ModelSource = async (robot) => {
  const answer = await fetch(`models/${encodeURIComponent(robot)}.urdf`);
  if (!answer.ok) throw new Error(`no model of ${robot}`);
  return answer.text();
};
let drafts = new Map<string, string>();

export function setModelSource(other: ModelSource): void {
  source = other;
}

/** Descriptions of robots that only a draft of the scene has. */
export function setDraftModels(models: {robot: string; text: string}[]): void {
  drafts = new Map(models.map(({robot, text}) => [robot, text]));
}

/** Description (URDF) of a robot; rejects where there is none. */
export function modelOf(robot: string): Promise<string> {
  const draft = drafts.get(robot);
  return draft === undefined ? source(robot) : Promise.resolve(draft);
}
