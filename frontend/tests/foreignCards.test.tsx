import { act, screen, waitFor } from "@testing-library/react";
import { useState } from "react";
import { afterEach, describe, expect, it, vi } from "vitest";
import { ForeignCards } from "../src/extension/ForeignCards";
import { fakeGateway, renderPage, renderWithin, robotServices } from "./page";

afterEach(() => {
  vi.unstubAllGlobals();
  window.history.replaceState(null, "", "/");
});

/** Answers `GET /extensions`; returns the paths that were asked for. */
function answer(extensions: { name: string; card: string | null }[], status = 200): string[] {
  const asked: string[] = [];
  vi.stubGlobal("fetch", async (request: Request | string) => {
    const { pathname } = new URL(typeof request === "string" ? request : request.url, "http://gateway");
    asked.push(pathname);
    if (pathname !== "/extensions") return Response.json({}, { status: 404 });
    return Response.json(status === 200 ? { extensions } : {}, { status });
  });
  return asked;
}

/** Loads a module that defines an element, which writes down when it is connected, and each robot that it is given. */
function moduleWith(tag: string) {
  const log: string[] = [];
  class Card extends HTMLElement {
    static observedAttributes = ["robot"];

    // React prefers a property of the name, if there is one.
    get robot(): string | null {
      return this.getAttribute("robot");
    }

    connectedCallback() {
      log.push(`connected with ${this.robot}`);
    }

    disconnectedCallback() {
      log.push("disconnected");
    }

    attributeChangedCallback(_: string, __: string | null, robot: string) {
      log.push(robot);
      this.textContent = `Odometer of ${robot}`;
    }
  }
  const load = vi.fn(async (_path: string) => customElements.define(tag, Card));
  return { load, log };
}

const broken = async () => {
  throw new SyntaxError("Unexpected token");
};

/** Shows the cards of /robot1; the returned function goes to another robot, null to a page without. */
function show(load?: (path: string) => Promise<unknown>) {
  let go: (robot: string | null) => void = () => {};
  function Page() {
    const [robot, setRobot] = useState<string | null>("/robot1");
    go = setRobot;
    return <main>{robot !== null && <ForeignCards robot={robot} {...(load && { load })} />}</main>;
  }
  renderWithin(robotServices(fakeGateway()).fleet, <Page />);
  return (robot: string | null) => act(() => go(robot));
}

describe("the card of an extension that is not built in", () => {
  it("is shown with its robot, and told of another one", async () => {
    const asked = answer([
      { name: "cameras", card: null },
      { name: "my_odometer", card: "/extensions/my_odometer/card.js" },
    ]);
    const { load, log } = moduleWith("my-odometer-card");
    const go = show(load);
    const card = await screen.findByRole("region", { name: "My odometer" });
    const element = card.querySelector("my-odometer-card");
    expect(card.textContent).toBe("My odometerOdometer of /robot1");
    go("/robot2");
    expect(card.textContent).toBe("My odometerOdometer of /robot2");
    expect(card.querySelector("my-odometer-card")).toBe(element);
    expect(log).toEqual(["/robot1", "connected with /robot1", "/robot2"]);
    expect(screen.getAllByRole("region")).toHaveLength(1);

    go(null);
    expect(log.at(-1)).toBe("disconnected");
    go("/robot1");
    expect(await screen.findByText("Odometer of /robot1")).toBeTruthy();
    expect(load.mock.calls).toEqual([["/extensions/my_odometer/card.js"]]);
    expect(asked).toEqual(["/extensions"]);
  });

  it("is not asked for on the page of a site of many", async () => {
    window.history.replaceState(null, "", "/sites/berlin/ui/robot");
    const asked = answer([{ name: "at_site", card: "/extensions/at_site/card.js" }]);
    const { load } = moduleWith("at-site-card");
    show(load);
    await act(async () => new Promise((resolve) => setTimeout(resolve, 50)));
    expect([asked.filter((path) => path.includes("extensions")), load.mock.calls]).toEqual([[], []]);
  });

  it.each([
    ["cannot be loaded", broken],
    ["does not define its element", async () => {}],
  ])("that %s is replaced by a sentence, and the others are shown", async (_, load) => {
    answer([
      { name: "broken", card: "/extensions/broken/card.js" },
      { name: "whole", card: "/extensions/whole/card.js" },
    ]);
    if (customElements.get("whole-card") === undefined) await moduleWith("whole-card").load("");
    show((path) => (path.includes("whole") ? Promise.resolve() : load()));
    const sentence = await screen.findByRole("status");
    expect(sentence.textContent).toBe("The card of the extension broken could not be loaded.");
    expect(await screen.findByText("Odometer of /robot1")).toBeTruthy();
  });

  it("whose element cannot be made is replaced by a sentence", async () => {
    const reported = vi.fn((event: ErrorEvent) => event.preventDefault());
    window.addEventListener("error", reported);
    answer([{ name: "fragile", card: "/extensions/fragile/card.js" }]);
    class Fragile extends HTMLElement {
      constructor() {
        super();
        throw new Error("not today");
      }
    }
    show(async () => customElements.define("fragile-card", Fragile));
    const sentence = await screen.findByRole("status");
    expect(sentence.textContent).toBe("The card of the extension fragile could not be loaded.");
    expect(reported).toHaveBeenCalled();
    window.removeEventListener("error", reported);
  });

  it("is imported by the browser", async () => {
    const source = "customElements.define('imported-card', class extends HTMLElement {})";
    answer([{ name: "imported", card: `data:text/javascript,${encodeURIComponent(source)}` }]);
    show();
    const card = await screen.findByRole("region", { name: "Imported" });
    expect(card.querySelector("imported-card")?.getAttribute("robot")).toBe("/robot1");
  });

  it.each([
    ["no extension has one", 200],
    ["the gateway does not know them", 404],
    ["they are refused", 403],
  ])("is not there where %s", async (_, status) => {
    const asked = answer([{ name: "cameras", card: null }], status);
    const go = show();
    await waitFor(() => expect(asked).toEqual(["/extensions"]));
    await act(async () => {}); // the answer is read
    expect(screen.getByRole("main").innerHTML).toBe("");
    go(null);
    go("/robot2");
    await act(async () => {});
    expect(asked).toEqual(["/extensions"]);
    expect(screen.getByRole("main").innerHTML).toBe("");
  });

  it("is on the page of a robot", async () => {
    const source = "customElements.define('on-page-card', class extends HTMLElement {})";
    answer([{ name: "on_page", card: `data:text/javascript,${encodeURIComponent(source)}` }]);
    renderPage(fakeGateway());
    const card = await screen.findByRole("region", { name: "On page" });
    expect(card.querySelector("on-page-card")?.getAttribute("robot")).toBe("/");
  });
});
