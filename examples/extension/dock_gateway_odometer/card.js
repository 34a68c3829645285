// The odometer's card on a robot's page: asks once a second, as long as it is shown.
class OdometerCard extends HTMLElement {
  static observedAttributes = ["robot"];

  connectedCallback() {
    this.timer = setInterval(() => this.show(), 1000);
    this.show();
  }

  disconnectedCallback() {
    clearInterval(this.timer);
  }

  attributeChangedCallback() {
    if (this.isConnected) this.show();
  }

  async show() {
    const robot = this.getAttribute("robot");
    const url = new URL(`../../odometer?robot=${encodeURIComponent(robot)}`, import.meta.url);
    const answer = await fetch(url).catch(() => null);
    if (robot !== this.getAttribute("robot")) return; // it shows another robot by now
    const metres = answer?.ok ? (await answer.json()).metres : null;
    this.textContent = metres === null ? "Not available" : `${(metres / 1000).toFixed(3)} km`;
  }
}

customElements.define("odometer-card", OdometerCard);
