# The image of backend/Dockerfile on a ROS base instead of the ROS wheels, for amd64 and arm64:
#
#   docker build -f backend/ros.Dockerfile -t dock-gateway .
#
# The program is dock-gateway-core, in an environment that sees the Python packages of the base. colcon compiles the docking
# actions. BASE: an image with a ROS installation in /opt/ros, colcon and a compiler, such as ros:jazzy and ros:kilted.
ARG BASE=ros:jazzy

FROM ${BASE} AS base

# What builds and installs. Nothing of it reaches the last stage but what the base has.
FROM base AS tools
RUN apt-get update \
    && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends ca-certificates python3-venv \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /src
ENV UV=/src/.tools/uv/bin/uv UV_LINK_MODE=copy UV_PYTHON_DOWNLOADS=never
COPY scripts/get-uv scripts/
COPY scripts/locks scripts/locks
RUN scripts/get-uv .tools/uv

FROM tools AS dashboard
COPY scripts/node-env scripts/build-dashboard scripts/
# The packages first: they change less often than the pages.
COPY frontend/package.json frontend/package-lock.json frontend/
RUN bash -c '. scripts/node-env && cd frontend && npm ci --no-audit --no-fund --loglevel=error && touch node_modules/.stamp'
COPY docs docs
COPY frontend frontend
RUN scripts/build-dashboard

FROM tools AS install
COPY pyproject.toml README.md LICENSE requirements.lock build-requirements.lock ./
COPY scripts/pack-wheels scripts/install-wheels scripts/
COPY backend backend
COPY --from=dashboard /src/frontend/dist frontend/dist
RUN scripts/pack-wheels && scripts/install-wheels /usr/bin/python3 /opt/dock-gateway --sourced

FROM tools AS messages
RUN apt-get update \
    && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends cmake g++ make python3-dev \
    && rm -rf /var/lib/apt/lists/*
COPY backend/action_tutorials_interfaces src
RUN bash -c '. /opt/ros/*/setup.bash && colcon build --merge-install --install-base /opt/docking-actions --cmake-args -DBUILD_TESTING=OFF'

FROM base
RUN useradd --uid 10001 --create-home --shell /usr/sbin/nologin dock \
    && install -d -o dock -g dock -m 700 /var/lib/dock-gateway /var/lib/hub-keys
COPY --from=messages /opt/docking-actions /opt/docking-actions
COPY --from=install /opt/dock-gateway /opt/dock-gateway
# As in backend/Dockerfile, which gives the reasons.
ENV PATH=/opt/dock-gateway/bin:$PATH \
    ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST \
    FASTDDS_BUILTIN_TRANSPORTS=UDPv4?non_blocking=true \
    PYTHONUNBUFFERED=1 \
    DOCK_GATEWAY_DATABASE_URL=sqlite:////var/lib/dock-gateway/history.db \
    DOCK_GATEWAY_SPOOL_PATH=/var/lib/dock-gateway/spool \
    DOCK_GATEWAY_STOP_PATH=/var/lib/dock-gateway/stops.json \
    ROS_LOG_DIR=/tmp/ros-log
USER dock
WORKDIR /home/dock
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=5s --start-period=20s --retries=3 \
    CMD ["/usr/bin/python3", "-c", "import http.client, os, ssl, sys; e = os.environ.get; s = ssl._create_unverified_context(); own = e('DOCK_GATEWAY_CLIENT_CERT'); own and s.load_cert_chain(own); where = ('127.0.0.1', int(e('DOCK_GATEWAY_PORT', '8000'))); c = http.client.HTTPSConnection(*where, timeout=4, context=s) if e('DOCK_GATEWAY_TLS_CERT') else http.client.HTTPConnection(*where, timeout=4); c.request('GET', '/healthz'); sys.exit(c.getresponse().status >= 400)"]
# Sources the base's ROS and the docking actions; `exec`, so that the process itself gets SIGTERM.
ENTRYPOINT ["bash", "-c", ". /opt/docking-actions/setup.bash && exec \"$@\"", "dock-gateway"]
CMD ["dock-gateway", "serve"]
