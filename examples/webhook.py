"""Print the alerts of a webhook that are signed with its secret: `WEBHOOK_SECRET=… python examples/webhook.py`."""

import base64
import hmac
import json
import os
import sys
from http.server import BaseHTTPRequestHandler, HTTPServer

SECRET = os.environ.get("WEBHOOK_SECRET") or sys.exit(
    "Set WEBHOOK_SECRET to the webhook's secret: see docs/extensions/webhooks.md"
)
PORT = int(os.environ.get("PORT", "9000"))


class Receiver(BaseHTTPRequestHandler):
    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers.get("content-length", 0)))
        signed = f"{self.headers['webhook-id']}.{self.headers['webhook-timestamp']}.".encode() + body
        mac = hmac.digest(base64.b64decode(SECRET.removeprefix("whsec_")), signed, "sha256")
        expected = b"v1," + base64.b64encode(mac)
        genuine = hmac.compare_digest(self.headers.get("webhook-signature", "").encode(), expected)
        self.send_response(204 if genuine else 401)
        self.end_headers()
        if genuine:
            print(json.loads(body)["text"], flush=True)


print(f"Waiting for alerts on http://127.0.0.1:{PORT}", flush=True)
HTTPServer(("127.0.0.1", PORT), Receiver).serve_forever()
