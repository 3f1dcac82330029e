// Saves the last part of the run as a file.
import {download, notify} from './dom';

const kLast_s = 60;

export async function saveIncident(): Promise<void> {
  try {
    const answer = await fetch(`incident?last=${kLast_s}`, {cache: 'no-store'});
    if (!answer.ok) throw new Error((await answer.text()).trim());
    const name = /filename="([^"]+)"/.exec(answer.headers.get('content-disposition') ?? '')?.[1];
    download(name ?? 'incident.journal', await answer.blob());
  } catch (error) {
    notify(
      `The incident was not saved: ${error instanceof Error ? error.message : error}`,
      'error'
    );
  }
}
