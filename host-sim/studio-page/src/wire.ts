// Wire that carries requests and messages between the page and a studio: a WebSocket to the server
// of the page. The playground replaces this file (playground/wire.ts).

export const IN_PAGE = false;

export type Wire = { readonly open: boolean; send(text: string): void };

// `cut` is called when the connection has ended; with a reason if reconnecting is of no use.
export function connect(
  news: (data: string | ArrayBuffer) => void,
  cut: (why?: string) => void,
): Wire {
  const token = encodeURIComponent(location.hash.slice(1));
  const socket = new WebSocket(`ws://${location.host}/link?token=${token}`);
  socket.binaryType = 'arraybuffer';
  socket.onmessage = ({ data }) => news(data);
  socket.onclose = () => cut();
  return {
    get open() {
      return socket.readyState === WebSocket.OPEN;
    },
    send: (text) => socket.send(text),
  };
}
