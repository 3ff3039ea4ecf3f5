// A worker that answers questions, and is started again when its library has died.

export class Answerer {
  #file;
  #begin;
  #died;
  #events;
  #worker = null;
  #open = new Map();
  #next = 0;

  /** `begin` asks what a fresh worker needs; `died` is told why the one before is gone. */
  constructor(file, { begin = () => {}, died = () => {}, events = () => {} } = {}) {
    [this.#file, this.#begin, this.#died, this.#events] = [file, begin, died, events];
  }

  /** Asks a question; an answer that never comes, since the worker died, is an error. */
  ask(kind, asked = {}, lent = []) {
    this.#worker ?? this.#start();
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#open.set(id, { resolve, reject });
      this.#worker.postMessage({ id, kind, ...asked }, lent);
    });
  }

  /** Ends the worker, whatever it does; the next question starts another. */
  stop(reason) {
    if (this.#worker) this.#end(reason);
  }

  #start() {
    this.#worker = new Worker(this.#file, { type: "module" });
    this.#worker.onmessage = ({ data }) => this.#told(data);
    this.#worker.onerror = (event) => this.#end(event.message ?? "the worker could not be started");
    this.#begin(this);
  }

  #told({ id, answer, error, died, ...event }) {
    if (id === undefined) return this.#events(event);
    const waiting = this.#open.get(id);
    this.#open.delete(id);
    if (died) {
      waiting?.reject(new Error(String(error ?? died)));
      return this.#end(String(error ?? died));
    }
    if (error) waiting?.reject(new Error(error));
    else waiting?.resolve(answer);
  }

  #end(reason) {
    this.#worker?.terminate();
    this.#worker = null;
    const open = [...this.#open.values()];
    this.#open.clear();
    open.forEach(({ reject }) => reject(new Error(reason)));
    this.#died(reason);
  }
}
