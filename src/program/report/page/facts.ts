import { units, wait, words, type PageData, type Run } from "./data";
import { fillList, find, make } from "./dom";

const count = (number: number, what: string) => `${number} ${what}${number === 1 ? "" : "s"}`;

/** Returns what was proven of the last instant, in a word or two. */
function describeCertificate(run: Run): string {
  if (run.is_running) return "at the end";
  const { passed, certified_to, checks } = run.certificate;
  if (passed === null) return run.wants_certificate ? "not made" : "not asked for";
  if (!passed) return "failed";
  if (certified_to === null || checks.length === 0) return "nothing moves";
  return certified_to > 0 ? `${Math.min(16, -Math.log10(certified_to)).toFixed(1)} digits` : "exact";
}

/** Returns what one wants to know of a computation before anything else of it. */
function listFacts(data: PageData): string[][] {
  const { run } = data, certified = ["equations certified", describeCertificate(run)], ran = ["run time", wait(run.wall.total)], threads = ["threads", String(run.threads)];
  if (run.is_at_rest) return [];
  if (!run.has_started) return [certified, ran, ["motion", "no start was found"], threads];
  const { position_violation: position, velocity_violation: velocity } = run;
  // A certificate of the equations says nothing about the error of the motion.
  return [certified, ran, ["error of the motion", data.error_time.length ? "see error against time" : "not measured"],
    ["steps", `${run.steps}` + (run.rejected ? ` (+${run.rejected})` : "")],
    ["simulated", words(run.t_reached - run.t_start, units.time)],
    ["violation", words(position === null || velocity === null ? null : Math.max(position, velocity), "", 2)],
    ["energy drift", words(run.drift, "", 2)], threads];
}

/** Fills in the warnings, then what ran, how well and how fast, and what was left out. */
export function fillHeadline(data: PageData): void {
  const { run } = data;
  const done = run.t_end > run.t_start ? (run.t_reached - run.t_start) / (run.t_end - run.t_start) : 1;
  document.title = `${run.is_running ? `${Math.round(100 * done)} % · ` : ""}${run.scene} – tanor`;
  find("scene").textContent = run.scene;
  const facts = listFacts(data), span = run.is_at_rest || !run.has_started ? "" : ` · ${words(run.t_reached - run.t_start, units.time)} simulated`;
  find("what").textContent = `${count(run.points, "point")}, ${count(run.rods, "rod")}, ${count(run.equations, "equation")}${span} · ${run.method} · tanor ${run.version}`;
  find("running").hidden = !run.is_running;
  find("done").style.width = `${100 * done}%`;
  find("done-words").textContent = `The run goes on: t = ${words(run.t_reached)} of ${words(run.t_end, units.time)} after ${wait(run.wall.total)}. This is its state when the page was written.`;
  find("headline").replaceChildren(...facts.map(([name, text]) => {
    const pair = make("div");
    pair.append(make("dt", name), make("dd", text));
    return pair;
  }));
  find("verdict").textContent = facts.slice(0, 2).map(([name, text]) => `${name}: ${text}`).join(" · ");
  find("computed").hidden = !facts.length && !run.left_out.length;
  find("warnings").hidden = run.warnings.length === 0;
  find("warnings").replaceChildren(...run.warnings.map((warning) => make("p", warning)));
  find("left-out-line").textContent = run.left_out.length ? `Left out, since the scene does not need it: ${run.left_out.map((what) => what.split(":")[0]).join(", ")}.` : "";
  find("left-out-line").title = run.left_out.join("\n");
}

function fillPhases(run: Run): void {
  const phases = Object.entries(run.wall).filter(([name, time]) => name !== "total" && time > 0);
  find("phases").parentElement!.hidden = phases.length === 0;
  const most = Math.max(...phases.map(([, time]) => time));
  find("phases").replaceChildren(...phases.map(([name, time]) => {
    const row = make("div", "", "phase"), bar = make("i");
    bar.style.width = `${(100 * time) / most}%`;
    row.append(make("span", name), bar, make("span", wait(time)));
    return row;
  }));
}

const namesOfEvents: Record<string, string> = { contact: "contact switches", singular: "singular configurations", event: "events" };

/** Returns "500 of 760 contact switches are listed, the first ones." */
function tellLeftOut({ events, events_seen }: PageData): string {
  return Object.entries(events_seen).map(([kind, seen]) => {
    const listed = events.filter((event) => event.kind === kind).length;
    return listed < seen ? `${listed} of ${seen} ${namesOfEvents[kind]} are listed, the first ones.` : "";
  }).filter((words) => words).join(" ");
}

export function fillDetails(data: PageData, seek: (time: number) => void): void {
  const { run, events } = data;
  fillPhases(run);
  find("certificate").parentElement!.hidden = !!run.is_at_rest;
  find("certificate").textContent = run.certificate.verdict
    || (run.is_running ? "It is made at the end." : run.wants_certificate ? `None was made: ${run.has_started ? "the motion did not arrive" : "there is no start"}.` : "No certificate was asked for.");
  find("checks").replaceChildren(...run.certificate.checks.map((check) => {
    const row = make("tr");
    row.append(Object.assign(make("td", check.words), { title: check.identity }), make("td", words(check.error)));
    return row;
  }));
  fillList("left-out", run.left_out.map((what) => make("li", what)), "nothing");
  find("events-card").hidden = events.length === 0;
  fillList("events", events.map((event) => {
    const row = make("li");
    row.append(make("i", "", `mark ${event.kind}`), make("span", event.what), make("span", words(event.t, units.time)));
    row.onclick = () => seek(event.t);
    return row;
  }));
  find("events-left-out").textContent = tellLeftOut(data);
  find("text").textContent = run.text;
  find("text").parentElement!.hidden = !run.text;
}
