import { describe, expect, it } from "vitest";
import { factWords, waitingWords } from "../../../src/extensions/cameras/LiveCamera";
import { type Picture, readPictures } from "../../../src/extensions/cameras/pictures";

const text = new TextEncoder();

function part(data: string, seconds: number): string {
  return `Content-Type: image/jpeg\r\nContent-Length: ${data.length}\r\nX-Timestamp: ${seconds}\r\n\r\n${data}\r\n--picture\r\n`;
}

/** A body that comes in pieces of a size. */
function body(whole: string, size: number): ReadableStream<Uint8Array> {
  const bytes = text.encode(whole);
  let at = 0;
  return new ReadableStream({
    pull(controller) {
      if (at >= bytes.length) controller.close();
      else controller.enqueue(bytes.slice(at, at + size));
      at += size;
    },
  });
}

async function all(stream: ReadableStream<Uint8Array>): Promise<Picture[]> {
  const pictures: Picture[] = [];
  for await (const picture of readPictures(stream)) pictures.push(picture);
  return pictures;
}

describe("a stream of pictures", () => {
  const stream = `--picture\r\n${part("one\r\n\r\n--picture\r\n", 1.5)}${part("two", 2)}`;

  it.each([1, 7, 50, 1000])("is read in pieces of %d bytes", async (size) => {
    const pictures = await all(body(stream, size));
    expect(await Promise.all(pictures.map(({ file }) => file.text()))).toEqual([
      "one\r\n\r\n--picture\r\n",
      "two",
    ]);
    expect(pictures.map(({ receivedAt }) => receivedAt)).toEqual([1500, 2000]);
    expect(pictures[0]?.file.type).toBe("image/jpeg");
  });

  it("leaves out a picture that was cut off", async () => {
    expect(await all(body(stream.slice(0, -20), 50))).toHaveLength(1);
  });

  it("that is none ends with an error", async () => {
    await expect(all(body("x".repeat(2000), 500))).rejects.toThrow("not one of pictures");
  });
});

describe("what is said of a camera", () => {
  const last = { receivedAt: 10_000, width: 640, height: 480 };
  const seen = { since: 9000, last, arrivals: [500, 600, 700], failure: null };

  it("is its rate, age and size", () => {
    expect(factWords(seen, 10_200, 800)).toBe("6.7 Hz · 0.2 s old · 640 × 480 · ");
    expect(factWords(seen, 60_000, 50_800)).toBe("0.0 Hz · 50 s old · 640 × 480 · ");
    expect(factWords({ ...seen, last: null }, 0, 0)).toBe("");
  });

  it.each([
    [seen, null, 12_900, ""],
    [seen, "the encoding is odd", 12_900, ""],
    [seen, null, 14_100, "No picture for 4 s"],
    [seen, "the encoding is odd", 14_100, "the encoding is odd"],
    [{ ...seen, failure: "no picture has come" }, null, 14_100, "no picture has come"],
    [{ ...seen, last: null }, null, 11_000, "Waiting for a picture…"],
    [{ ...seen, last: null }, null, 14_000, "No picture for 5 s"],
    [{ ...seen, since: 60_000 }, null, 60_500, "Waiting for a picture…"],
  ])("is why no picture comes, or for how long", (state, hint, now, words) => {
    expect(waitingWords(state, hint, now)).toBe(words);
  });
});
