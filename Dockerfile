# docker build -t cornerfix . && docker run -p 127.0.0.1:8080:8080 -v cornerfix:/data cornerfix
FROM debian:12 AS build
COPY scripts/install_dependencies.sh /source/scripts/
RUN /source/scripts/install_dependencies.sh build
COPY . /source
WORKDIR /source
RUN cmake --preset release -D CORNERFIX_BUILD_TESTS=OFF -D CORNERFIX_BUILD_BENCH=OFF \
 && cmake --build --preset release \
 && cmake --install build/release --strip --prefix /usr/local
# OpenCV's packages bring 200 MB of graphics libraries; what the program really loads is a tenth of that.
# glibc itself comes with the runtime stage.
RUN mkdir -p /runtime/lib /runtime/leaflet /runtime/chart.js \
 && ldd /usr/local/bin/cornerfix | awk '$3 ~ "^/" && $1 !~ "^lib(c|m|pthread|dl|rt|resolv)\\.so" { print $3 }' \
    | xargs cp -L -t /runtime/lib \
 && cp -L /usr/share/javascript/leaflet/leaflet.js /usr/share/javascript/leaflet/leaflet.css /runtime/leaflet \
 && cp -L /usr/share/javascript/chart.js/chart.min.js /runtime/chart.js

FROM debian:12-slim
COPY --from=build /usr/local/bin/cornerfix /usr/local/bin/
COPY --from=build /usr/local/share/cornerfix /usr/local/share/cornerfix
COPY --from=build /runtime/lib /usr/local/lib
COPY --from=build /runtime/leaflet /usr/share/javascript/leaflet
COPY --from=build /runtime/chart.js /usr/share/javascript/chart.js
RUN ldconfig \
 && useradd --system --uid 10001 --home-dir /data --shell /usr/sbin/nologin cornerfix \
 && install -d -o cornerfix -g cornerfix /data
USER cornerfix
VOLUME /data
# Inside a container loopback reaches nobody, so all addresses are bound on purpose: publish the port to trusted networks
# only, or make tokens and set CORNERFIX_ALLOW_INSECURE_LISTEN to false. All settings: docs/configuration.md.
ENV CORNERFIX_DATABASE=/data/cornerfix.db CORNERFIX_LISTEN=0.0.0.0 CORNERFIX_PORT=8080 CORNERFIX_ALLOW_INSECURE_LISTEN=true
EXPOSE 8080
HEALTHCHECK --interval=10s --timeout=3s --start-period=5s \
  CMD ["bash", "-c", "exec 3<>/dev/tcp/127.0.0.1/$CORNERFIX_PORT && printf 'GET /healthz HTTP/1.0\\r\\n\\r\\n' >&3 && head -1 <&3 | grep -q ' 200 '"]
ENTRYPOINT ["cornerfix"]
CMD ["serve"]
